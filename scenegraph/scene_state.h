// The state of a Scene: the tables behind its handles, and which object uses which, so that an edit knows which bounds it
// changes.
#pragma once

#include <atomic>
#include <mutex>
#include <span>
#include <unordered_map>

#include "base/error_without_file.h"
#include "scenegraph/child_boxes.h"
#include "scenegraph/scene.h"
#include "scenegraph/scene_tables.h"

namespace occam {

/// Grows a box of a cage's undisplaced surface to hold the displaced one.
Box3d grown_by_displacement(const Cage& cage, const Box3d& box) noexcept;

/// Returns the vertices that no face of the cage has, in ascending order.
std::vector<std::uint32_t> find_unused_vertices(const Cage& cage);

/// Returns the box of the positions, one for each vertex of the slot's cage, that are not of unused vertices.
Box3d box_of_used(const CageSlot& slot, std::span<const Vec3f> positions) noexcept;

/// Computes the bounds of a slot's cage and of what deforms it, and the edges at its poles. The slot stays as it is if there
/// is no memory for them; a cage without keys, skin and morph targets needs none.
void find_bounds(CageSlot& slot);
/// Computes the edges at the poles alone.
void find_poles(CageSlot& slot) noexcept;

/// Returns a number that is unique in the process, since renderers use it as a key for data that they keep across frames and
/// scenes.
std::uint64_t next_identity() noexcept;

struct Scene::State {
    /// Lists what depends on a node's transform besides its parent's bounds.
    struct Dependents {
        WatcherList<SkinId> skins;    ///< skins for which the node lies between a joint and the base
        Watchers users;               ///< skinned nodes for which the node lies between them and the base of their skin
        std::uint64_t marked_in = 0;  ///< the State::round in which all of them were marked, if none was added since
    };
    /// The values that pose() found before it moved a node.
    struct Rest {
        std::optional<Trs> place;
        std::optional<Mat4d> matrix;
        std::optional<std::vector<float>> weights;
    };
    struct NodeRecord : Node {
        std::uint64_t added = 0;                  ///< rises from one added node to the next
        std::uint32_t removed_children = 0;       ///< null handles in the list of a node with many children
        std::unique_ptr<ChildBoxes> child_boxes;  ///< for a node with many children; made by its first refit
        Watchers instances;                       ///< nodes whose instance_of is this node
        NodeId first_original;                    ///< for what copy() made: the node at the start of a chain of copies
        std::unique_ptr<Dependents> dependents;
        std::unique_ptr<Rest> rest;
        bool is_listed_with_keys = false;  ///< in nodes_with_keys
        bool has_stale_keys = false;       ///< NodeKey::node_from_skin has to be found again
        bool has_stale_links = false;      ///< of a skinned node: link_user() has to register it again
    };
    struct SkinRecord : SkinSlot {
        std::vector<int> parent_joint;     ///< the nearest joint above each joint, by index; below 0: none
        bool dirty = true;                 ///< mesh_poses are out of date
        bool has_stale_keys = true;        ///< key_poses have to be found again
        bool has_stale_links = false;      ///< what link_skin() finds is out of date
        bool is_listed_with_keys = false;  ///< in skins_with_keys
        Watchers users;
        std::uint64_t users_marked_in = 0;  ///< a State::round
    };
    /// The state of pose() for the scene itself, and for each subtree that copy() or add() made.
    struct Posed {
        std::unordered_map<NodeId, NodeId> node_of;  ///< from what clips name to what they move
        std::vector<SkinId> skins;                   ///< for copies: the skins made for the copy
        std::vector<NodeId> placed, weighted;        ///< whose place or morph weights the last pose() moved
    };
    struct RefitStep {
        NodeId id;
        bool children_are_done;
    };
    struct CageRecord : CageSlot {
        Watchers users;
        std::uint64_t users_marked_in = 0;  ///< a State::round
        Contents contents;                  ///< whatever its materials are
        FaceLayers layers;
        // What the cage's own materials make of it: see sum_up_materials().
        Contents::Kinds material_kinds = 0;
        FaceLayers::Passing passing;
    };
    struct LightRecord : Light {
        Watchers users;
    };
    struct CameraRecord : CameraLens {
        Watchers users;
    };
    struct MaterialRecord : Material {
        Watchers users;             ///< nodes whose override names the material
        WatcherList<CageId> cages;  ///< cages that name it
    };
    struct TextureRecord {
        std::shared_ptr<Texture> texture;   ///< renderers hold it until they have decoded it, so only replace() changes it
        std::uint64_t added = 0;            ///< rises from one added texture to the next; replace() leaves it as it is
        WatcherList<MaterialId> materials;  ///< materials that use the texture
        WatcherList<CageId> cages;          ///< cages that it displaces
    };

    /// A node with more children keeps their boxes in a tree, and leaves gaps in its list where some were removed.
    static constexpr std::size_t kManyChildren = 2 * ChildBoxes::kBlock;

    const std::uint32_t generation = next_scene_generation();
    SceneTable<NodeRecord, NodeTag> nodes{generation};
    SceneTable<CageRecord, CageTag> cages{generation};
    SceneTable<MaterialRecord, MaterialTag> materials{generation};
    SceneTable<TextureRecord, TextureTag> textures{generation};
    SceneTable<LightRecord, LightTag> lights{generation};
    SceneTable<CameraRecord, CameraTag> cameras{generation};
    SceneTable<SkinRecord, SkinTag> skins{generation};
    SceneTable<Clip, ClipTag> clips{generation};
    std::vector<ClipId> clip_order;
    struct Recorder;
    Recorder* recorder = nullptr;  ///< not null while record_shutter() runs
    int shutter_segments = 0;
    std::size_t things_with_keys = 0;  ///< nodes, skins and cages
    // What record_shutter() gave keys to; some may have lost theirs.
    std::vector<NodeId> nodes_with_keys;
    std::vector<SkinId> skins_with_keys;
    std::vector<CageId> cages_with_keys;
    std::unordered_map<NodeId, Posed> posed;  ///< by its top node; the key of the scene itself is a null handle
    NodeId root;
    std::size_t faces = 0, mesh_triangles = 0;  ///< of all cages
    bool has_lost_bounds = false;               ///< all bounds are out of date, whatever the nodes say
    /// Rises where a refit begins. Until then nodes that were marked stay dirty, so what has marked its users in this round
    /// need not do it again: a node that becomes a user is marked then.
    std::uint64_t round = 1;
    mutable std::atomic<std::size_t> looked_at_so_far{0};  ///< see Scene::looked_at()
    mutable std::atomic<int> frames{0};                    ///< number of FrameLocks alive
    std::mutex refitting;  ///< held by refit(): frames of several renderers may begin at once

    void require_editable() const
    {
        if (frames.load(std::memory_order_acquire) > 0)
            throw error_without_file(
                "edits of a scene have to wait for the end of the frame that renders it, or Query::end()");
    }
    /// Also throws while a shutter is recorded.
    void require_unrecorded() const
    {
        require_editable();
        if (recorder)
            throw error_without_file(
                "while a shutter is recorded, the scene's nodes, and the cages and skins that they have, stay the same "
                "ones");
    }
    /// Returns the value of a live handle and throws Error for any other.
    template <class T, class Tag>
    static T& at(SceneTable<T, Tag>& map, Handle<Tag> id, const char* kind)
    {
        if (T* value = map.find(id)) return *value;
        throw error_without_file(
            std::string("dead or foreign handle of a ") + kind,
            id ? "slot " + std::to_string(id.slot) + ", generation " + std::to_string(id.generation) : "no handle");
    }
    template <class T, class Tag>
    static const T& at(const SceneTable<T, Tag>& map, Handle<Tag> id, const char* kind)
    {
        return at(const_cast<SceneTable<T, Tag>&>(map), id, kind);
    }

    // Each throws Error for a dead handle and for one of another scene.
    void check_handles(const Material& material) const;
    void check_handles(const Cage& cage) const;

    /// Marks the node, its ancestors, and all nodes that show one of them as an instance. It stops at nodes that are already
    /// dirty, because everything above them is dirty too.
    void mark_dirty(NodeId id) noexcept;
    /// Records in the parent that its data about this child's box, transform and visibility are out of date, without marking
    /// it.
    void touch_in_parent(const NodeRecord& node) noexcept;
    /// Does the same for the child in that place.
    void touch_child(NodeRecord& parent, std::uint32_t place_among_siblings) noexcept;
    /// Marks all nodes by one flag, where there is no memory to find those that an edit affects. It needs no memory itself.
    void lose_bounds() noexcept;
    /// Makes all nodes dirty if they were marked by lose_bounds().
    void find_lost_bounds() noexcept;
    /// Enters a new node into the lists of its parent and of what it refers to.
    void link_node(NodeId id);
    /// Removes a child from a node's list, at a mean cost that does not grow with the list.
    void leave_parent(NodeId parent, std::uint32_t place_among_siblings) noexcept;
    /// Removes one node of a subtree that is removed.
    void remove_one(NodeId id) noexcept;
    void mark_users_dirty(CageRecord& cage) noexcept;
    void mark_users_dirty(SkinRecord& skin) noexcept;
    bool is_instance_of(NodeId id, NodeId shown) const noexcept;   ///< false also for a node that was removed
    bool wears(NodeId id, const SkinRecord& skin) const noexcept;  ///< likewise
    bool is_worn(SkinRecord& skin) const noexcept;                 ///< by any node
    static Error shows_itself(const std::string& name);
    /// Returns whether `below` lies in what `above` shows, or is `above`. It looks down from the one and up from the other,
    /// and costs twice what the smaller of the two searches costs.
    bool is_shown_by(NodeId below, NodeId above) const;
    /// Refits one node and returns the number of children's boxes it visited beyond those that Scene::refit() has visited.
    std::size_t refit_node(NodeId id, NodeRecord& node);
    /// Returns what a node holds itself, without what lies below it.
    Contents own_contents(const NodeRecord& node) const noexcept;
    /// Fills what a cage alone decides, after repairing it; the repairs are added to the warnings.
    static void make_record(Cage cage, CageRecord& record, std::vector<std::string>& warnings);
    /// Gives a cage its handle, sums up what it holds and registers it with its materials and the texture that displaces it;
    /// it is called where the cage's polygons or materials are new.
    void take_contents(CageId id, CageRecord& cage);
    void note_looked_at(std::size_t number) const noexcept { looked_at_so_far.fetch_add(number, std::memory_order_relaxed); }
    Contents::Kinds kinds_of_all(const std::vector<MaterialId>& list) const noexcept;
    /// Returns what counts of those faces of a cage that light may pass, if it has these materials.
    FaceLayers::Passing passing_faces(const CageRecord& cage, const std::vector<MaterialId>& shown) const noexcept;
    /// Brings up to date what the cage's own materials make of it, so that nodes that show them need not look at each.
    void sum_up_materials(CageRecord& cage) const noexcept;
    /// Registers a material with its textures.
    void watch_textures(MaterialId id, const Material& material);
    /// Registers a node with its cages, its light, its camera and the materials of its override.
    void watch_contents(NodeId id, const NodeRecord& node);
    /// Gives a node another value of what watch_contents() registers.
    template <class T>
    void change_contents(NodeId id, T NodeDesc::*member, T value);
    /// Marks the nodes that show the material, and sums up the cages that name it.
    void mark_users_dirty(MaterialRecord& material) noexcept;
    /// Counts a cage's faces into the scene's, or with `sign` -1 out of them.
    void count_faces(const CageRecord& cage, int sign) noexcept;

    /// Pushes the nodes that must be up to date before this one.
    void push_below(NodeRecord& node, std::vector<RefitStep>& todo) const;

    // Each of these is called before an edit writes: of a node's own values; of its transform, on which skins and other
    // nodes may depend; of a cage's vertices. A recorder then takes what was there, and otherwise keys are dropped.
    void about_to_change(NodeId id, NodeRecord& node);
    void about_to_move(NodeId id, NodeRecord& node);
    void about_to_write(CageId id, CageRecord& cage);
    /// Drops the keys of a node that pose() is about to pose, whether it will change or not; a recorder takes only changes.
    void about_to_pose(NodeId id, NodeRecord& node)
    {
        if (!recorder) about_to_move(id, node);
    }
    void drop_keys(NodeId id, NodeRecord& node) noexcept;
    void drop_keys(SkinRecord& skin) noexcept;
    void drop_keys(CageRecord& cage) noexcept;
    /// Finds NodeKey::node_from_skin again where it is stale, and gives a node without keys those keys that it needs because
    /// it or its skin's base hangs below nodes that move.
    void keep_skin_in_place(NodeId id, NodeRecord& node, const SkinRecord& skin);
    /// Keeps of the keys of a node without a skin only what moves the node itself.
    void keep_own_keys(NodeId id, NodeRecord& node);
    /// Finds SkinSlot::key_poses again from the keys of the joints, and of what lies between them and the base.
    void keep_skin_moving(SkinId id, SkinRecord& skin);
    /// Says that a skin's keys are stale, and marks the nodes that it deforms. If there are none, the skin has no keys until
    /// a node wears it, because only the refit of such a node finds them again.
    void lose_keys(SkinRecord& skin) noexcept;
    /// Drops the keys of a skin if the node that has just ceased to wear it was the last one. A dead handle has no effect.
    void lose_wearer(SkinId id) noexcept;
    /// Returns the nodes that have a camera, in the order in which they were added.
    std::vector<NodeId> nodes_with_cameras() const;
    NodeKey key_of(const NodeRecord& node, NodeId id) const;
    void take_key(Recorder& record);
    void store_keys(Recorder& record);

    /// Notifies the nodes above and the skins that a node's transform has changed.
    void place_changed(NodeId id, NodeRecord& node) noexcept;
    void place(NodeId id, NodeRecord& node, const Mat4d& parent_from_node);
    /// Adds a skin, some of whose joints may have been removed.
    SkinId add_skin(Skin skin);
    NodeId parent_of(NodeId id) const noexcept;  ///< none for the root and for a node that was removed
    /// Returns the lowest node above all joints; none if one of them is the root, or if there are none. The cost is that of
    /// the nodes above them, each once.
    NodeId base_of(const std::vector<NodeId>& joints) const;
    /// Finds the nearest joint above each joint, below the base, at the same cost.
    void find_parent_joints(SkinRecord& skin) const;
    /// Finds the parents of a skin's joints and the base, and registers the skin with the nodes between them. Joints that
    /// were removed do not count.
    void link_skin(SkinId id);
    /// Returns whether all joints were removed.
    bool has_no_joint(const SkinRecord& skin) const noexcept;
    /// Registers a skinned node with the nodes between it and the skin's base, which is found again if it has to be.
    void link_user(NodeId id);
    /// Says that a node was moved below another one or is about to be removed, so that skins and skinned nodes have to be
    /// linked again.
    void lose_links(const NodeRecord& node) noexcept;
    /// Lists the nodes with which link_skin() registers a skin: each joint and what lies between it and the base.
    std::vector<NodeId> nodes_of_skin(const SkinRecord& skin) const;
    // These are as the nodes are posed, or at one key of the shutter.
    std::vector<Mat4d> poses_of(const SkinRecord& skin, std::optional<std::size_t> key = {}) const;
    Mat4d node_from_skin(NodeId node, const SkinRecord& skin, std::optional<std::size_t> key = {}) const;
    Mat4d path(NodeId above, NodeId node, std::optional<std::size_t> key = {}) const;  ///< above_from_node
    NodeId lowest_common(NodeId a, NodeId b) const;  ///< lowest common ancestor; a node counts as its own
    /// Holds the weighted sums of the values that clips give to one node.
    struct PoseSum;
    /// Writes the mean of these values into a node.
    void write_pose(NodeId id, const PoseSum& sum);
    /// Writes those of all nodes in this order. What the last pose() moved and they leave out returns to its rest value.
    void write_poses(Posed& of, const std::vector<NodeId>& order, const std::unordered_map<NodeId, PoseSum>& sums);
    // Each of these gives a node that pose() moved its rest value back, and forgets it. A dead handle has no effect.
    void restore_place(NodeId id);
    void restore_weights(NodeId id);
    /// Returns the state of pose() for what is a copy within the subtree that is copied.
    Posed copy_within(const Posed& original, const Posed& copy, const std::unordered_map<SkinId, SkinId>& skin_of) const;
    /// Returns what copy() makes a node from, without the skin and the instance that it shows.
    NodeDesc desc_of_copy(NodeId original) const;
    /// Shows another node's subtree in this one, and registers it there.
    void show_instance(NodeId id, NodeId shown);
    class Addition;
    /// Lists a subtree's nodes, parents first. Throws Error if a copy of them below `parent` would show itself.
    std::vector<NodeId> subtree_to_copy(NodeId subtree, NodeId parent) const;
};

}  // namespace occam
