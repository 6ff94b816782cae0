// The scene graph: nodes and what they hold. The application owns it and may change it between any two frames.
//
// An edit of a node costs its path to the root, up to which it marks bounds as dirty; what places a node below another one
// looks for circles as well, and what writes, replaces or copies contents costs as much as these hold, and as there are
// nodes that show them. A renderer borrows the scene for a frame, refits what is dirty before the first tile, and writes
// nothing else to it.
//
// Space    a node's transform is relative to its parent; the root's parent is the world, whose axes are right-handed, with
//          y up by convention only.
// Threads  one thread edits at a time; an edit while a frame renders is refused with an Error (FrameLock). Public members
//          are not guarded: change them between frames. Several threads may begin frames of one scene at once.
// Memory   What a function returns by reference is valid until the next edit. A scene may be moved, but not while it is
//          borrowed; one that was moved from may only be destroyed or assigned to.
// Errors   a call with a dead or foreign handle throws an Error and changes nothing, but for those that ask by it and are
//          noexcept, which return null or false, and remove(AddedScene), which passes over what is gone.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenegraph/animation.h"
#include "scenegraph/cage.h"
#include "scenegraph/camera.h"
#include "scenegraph/contents.h"
#include "scenegraph/deform_bounds.h"
#include "scenegraph/deformed_poles.h"
#include "scenegraph/light.h"
#include "scenegraph/material.h"
#include "scenegraph/ray_kind.h"
#include "scenegraph/texture.h"

namespace occam {

/// Describes a node to be made, and what it holds. Everything is optional.
struct NodeDesc {
    std::string name{};
    Trs place{};                          ///< in the parent's axes
    std::optional<Mat4d> matrix{};        ///< instead of `place`; affine: the last row is 0, 0, 0, 1
    std::vector<CageId> cages{};          ///< usually one; a glTF mesh brings one for each primitive
    std::vector<MaterialId> materials{};  ///< override of the cages' own slots, in order; empty: none
    NodeId instance_of{};  ///< shows that node's subtree here too, without that node's own transform and visibility
    LightId light{};
    CameraId camera{};
    SkinId skin{};  ///< its joints place the skinned cages, and this node's own transform does not count for them, unless
                    ///< it or that of a node above is singular: then nothing is seen of them
    std::vector<float> morph_weights{};  ///< empty: the cage's own
    bool visible = true;                 ///< false hides the subtree below its parent; its instances stay visible
    std::uint8_t seen_by =
        RayKind::All;  ///< rays of other kinds pass through the surfaces of the subtree and of its instances
    LightGroups lit_by =
        kAllGroups;  ///< placed lights of other groups do not light the surfaces of the subtree and of its instances
};

/// What of a node may change while the shutter is open, at one of the shutter's keys.
struct NodeKey {
    Mat4d parent_from_node{1};
    Mat4d node_from_skin{1};  ///< as Node::node_from_skin
    std::vector<float> morph_weights;
    bool visible = true;  ///< from this key to the next
    friend bool operator==(const NodeKey&, const NodeKey&) = default;
};

/// A node as the engine reads it.
struct Node : NodeDesc {
    NodeId parent;
    std::vector<NodeId> children;  ///< in order of addition; a node with many has null handles where some were removed
    std::uint32_t place_among_siblings = 0;  ///< index in the parent's list of children
    Mat4d parent_from_node{1};
    /// Holds the subtree and instance_of at all keys of the shutter, in the node's own axes; valid after Scene::refit().
    Box3d bounds;
    Contents contents;        ///< of the subtree and of instance_of; valid after Scene::refit()
    Mat4d node_from_skin{1};  ///< for a skinned node, from the axes of SkinSlot::mesh_poses; valid after Scene::refit()
    /// One entry for each key of the shutter if the node changes while it is open, else empty. Between two keys, matrices
    /// are interpolated as elements, after they are multiplied along the path to the world, and vertices as positions.
    std::vector<NodeKey> keys;
    bool dirty = true;  ///< bounds and contents of this node and of all its ancestors are out of date

    /// Returns whether the node is visible at any time while the shutter is open, if what is above it is.
    bool is_visible_in_shutter() const noexcept;
};

/// Returns the bounds of what the node shows at all keys of the shutter, in its parent's axes; empty if it is never
/// visible.
Box3d box_in_parent(const Node& node) noexcept;
/// Returns the largest factor by which a node's transform lengthens anything, at all keys of the shutter.
double largest_stretch_to_parent(const Node& node) noexcept;

/// A cage and the counters that tell the engine's caches when it has changed.
struct CageSlot {
    Cage cage;
    Box3d bounds;  ///< bounds of the control points plus displacement, object axes, at all keys of the shutter
    /// The positions at each key of the shutter, and their bounds, if Scene::write_vertices() changed them while it was
    /// recorded; else empty.
    std::vector<std::vector<Vec3f>> key_positions;
    std::vector<Box3d> key_bounds;
    CageId id;
    std::uint64_t identity = 0;  ///< unique in the process; a new one when topology is replaced
    std::uint64_t positions_version = 0;
    std::uint32_t largest_face = 4;  ///< corners; at least 4, and 4 for an OnDemandCage
    PoleFaces pole_faces;            ///< of the cage's polygons
    Poles poles;          ///< in lengths of the object axes, at all keys of the shutter; of a deformed cage those at rest
    Vec3d pole_reach{0};  ///< how far these edges reach along each axis
    DeformedPoles deformed_poles;
    std::size_t derived_points = 0;              ///< the most that a pose has (large_parts.h); 0 for an OnDemandCage
    std::vector<std::uint32_t> unused_vertices;  ///< those that no face has, in ascending order; bounds do not hold them
    DeformBoundsTable deform;          ///< one part, the whole cage; none if no skin and no morph target deforms the cage
    std::function<Cage()> make;        ///< for an OnDemandCage, whose `cage` has a name and materials only
    std::vector<std::string> repairs;  ///< of what made() returns: the lines of sanitize(), which name the cage

    bool is_deformed() const noexcept { return deform.size() > 0; }
    bool is_on_demand() const noexcept { return bool(make); }
    /// Returns an OnDemandCage's polygons in a slot of the same identity. Throws Error; see OnDemandCage::make.
    CageSlot made() const;
};

/// A skin and the poses of its joints.
struct SkinSlot {
    Skin skin;
    /// Lowest common ancestor of all joints that are left; null if it lies above the root, or if none is left, and then the
    /// skin deforms nothing.
    NodeId base;
    std::vector<Mat4d> mesh_poses;  ///< base_from_mesh of each joint; valid after Scene::refit(). A removed joint: identity
    std::vector<std::vector<Mat4d>> key_poses;  ///< mesh_poses at each key of the shutter; empty: no joint moves, or no node
                                                ///< wears the skin
};

/// What Scene::add() made of another scene.
struct AddedScene {
    NodeId node;                ///< was the other scene's root
    std::vector<ClipId> clips;  ///< in file order
    Environment environment;    ///< the other scene's own, which is not used unless the application assigns it
    // All that came with it.
    std::vector<CageId> cages;
    std::vector<MaterialId> materials;
    std::vector<TextureId> textures;
    std::vector<LightId> lights;
    std::vector<CameraId> cameras;
    std::vector<SkinId> skins;
};

class ChildBoxes;

/// Returns the bounds of a cage that a node shows, at all keys of the shutter, in the node's axes. It visits no vertex.
/// skin   the node's skin, or null; the poses of nodes and skins must be up to date (Scene::refit())
Box3d cage_bounds(const Node& node, const CageSlot& slot, const SkinSlot* skin) noexcept;
/// Returns the bounds at one key of the shutter. What has no keys counts as it is posed.
Box3d cage_bounds(const Node& node, const CageSlot& slot, const SkinSlot* skin, std::size_t key) noexcept;
/// Returns lengths, in the node's axes, that the edges at the poles of a cage that it shows do not exceed at any key.
Poles cage_poles(const Node& node, const CageSlot& slot, const SkinSlot* skin);
/// Returns a length that they do not exceed where this map has placed them.
double longest_pole_edge(const Node& node, const CageSlot& slot, const SkinSlot* skin, const Mat3d& map);

/// The largest number of segments of a shutter.
inline constexpr int kMaxShutterSegments = 32;

class Scene {
public:
    Scene();
    Scene(Scene&&) noexcept;
    Scene& operator=(Scene&&) noexcept;
    ~Scene();

    // Nodes. The root always exists; removing a node removes its subtree. What is placed may be of any finite size, and lie
    // anywhere. But what is more than 10^22 times smaller than all that is shown together vanishes from pictures and to
    // queries: FrameStats::warnings counts the nodes beyond 1e16 beside which the rest does, and those whose place in the
    // world is no finite number, which are not seen themselves.
    NodeId root() const noexcept;
    NodeId add_node(NodeId parent, NodeDesc desc);  ///< also throws if the node would show itself through instance_of
    void remove(NodeId id);
    const Node& node(NodeId id) const;
    /// Hangs the node and its subtree below another node, as the last of its children. The node keeps its transform in the
    /// axes of its parent, which is another one now: to keep its place in the world, an application also calls
    /// set_transform(id, inverse(world_from_node(parent)) * world_from_node(id)), the latter of before. Skins follow their
    /// joints. Throws Error if the node is the root, or shows `parent`.
    void set_parent(NodeId id, NodeId parent);
    void set_transform(NodeId id, const Trs& place);
    void set_transform(NodeId id, const Mat4d& parent_from_node);
    void set_visible(NodeId id, bool visible);
    void set_seen_by(NodeId id, std::uint8_t ray_kinds);
    void set_lit_by(NodeId id, LightGroups groups);
    void set_cages(NodeId id, std::vector<CageId> cages);
    void set_materials(NodeId id, std::vector<MaterialId> materials);
    void set_light(NodeId id, LightId light);       ///< null: none
    void set_camera(NodeId id, CameraId camera);    ///< null: none
    void set_instance_of(NodeId id, NodeId shown);  ///< null: none; throws Error if `shown` shows the node
    void set_skin(NodeId id, SkinId skin);          ///< call it after the skin's nodes exist, because a skin names them
    void set_morph_weights(NodeId id, std::vector<float> weights);  ///< empty: the cage's own
    /// Returns the node of that name that was added first, `below` itself or a node of its subtree, or a null handle. If
    /// `below` is null, it looks everywhere.
    NodeId find_node(std::string_view name, NodeId below = {}) const;
    Mat4d world_from_node(NodeId id) const;

    // Animation. Poses are written into the nodes, as if by set_transform() and set_morph_weights().

    /// Poses the clips' nodes. What an earlier pose() of the same `of` changed of a node (its place or its morph weights)
    /// and these clips do not change returns to its rest value, even if a pose() of another `of` has changed it since. A
    /// value that the application sets itself becomes the new rest value. Several clips that move the same property are
    /// blended by their weighted mean (rotations along the shorter arc). Seconds must be finite, and weights finite and at
    /// least 0.
    /// of   null: the clips move the nodes that they name; a node that copy() made: they move the counterparts in that copy,
    ///      which may be a copy of a copy; AddedScene::node: they move what they name in that part
    void pose(std::span<const ClipAt> clips, NodeId of = {});
    void pose(ClipId clip, double seconds);
    /// Copies the subtree below `parent`. The nodes and the skins whose joints lie in the subtree are new, and the rest is
    /// shared, so each copy has a pose of its own, as have the copies within it; keys of the shutter are not copied. The
    /// skins are removed with the copy, unless a node elsewhere wears them. Throws if `parent` lies in the subtree.
    NodeId copy(NodeId subtree, NodeId parent);
    /// Adds all of another scene below `parent`, as scene.add(occam::load("fox.glb"), scene.root()) does. Its content is
    /// moved, not copied, and all of its handles are dead from then on. It shows what it showed, and has a pose of its own,
    /// as have the copies within it, but the keys of record_shutter() are dropped. Warnings and notes are appended, and so
    /// are those files that are not listed yet; variants are not. If there is not enough memory, this scene stays as it is,
    /// and the other one is lost; after any other Error both stay as they are.
    AddedScene add(Scene&& part, NodeId parent);
    /// Removes the subtree of AddedScene::node as it is now, and the clips, skins, cages, lights and cameras that came with
    /// the other scene, whatever still refers to them; then its materials and textures, but for those that something uses.
    void remove(const AddedScene& part);
    ClipId find_clip(std::string_view name) const;  ///< the first one in file order, or a null handle

    // Motion blur. What moves while the shutter of the next frame is open is recorded as poses at evenly spaced keys.

    /// Calls pose(tau) for tau = 0 (the shutter opens), 1 / segments, ..., 1 (it closes), which poses the scene by
    /// set_transform(), set_visible(), set_morph_weights(), write_vertices() and pose(); records what changes; and calls
    /// pose(0.5), so that everything without keys, lights and the edited nodes' own values are those of mid-shutter. An
    /// earlier recording is dropped. While it is recorded, nodes can be neither added nor removed nor given another
    /// parent, skin or instance or other cages, and cages and skins can be neither removed nor replaced. The scene itself
    /// can be neither moved elsewhere nor assigned to: that is an Error when `pose` returns. If `pose` throws, no keys are
    /// left. A later edit of a node or of a cage's vertices drops its keys, and skins follow what is left of the motion of
    /// their joints.
    /// segments   1, 2, 4, 8, 16 or 32
    void record_shutter(int segments, const std::function<void(double tau)>& pose);
    void clear_shutter();
    /// Returns the number of segments; 0 if nothing moves while the shutter is open.
    int shutter_segments() const noexcept;
    /// Returns world_from_node() at each key of the shutter; empty if neither the node nor anything above it moves.
    std::vector<Mat4d> world_from_node_keys(NodeId id) const;

    // What nodes refer to. It is allowed to remove a cage, a light, a camera or a skin that nodes still refer to: they then
    // no longer show it. A material or a texture that is in use cannot be removed, because surfaces would then look like
    // something else; the Error names a user. Cages and the overrides of nodes use materials; materials, the displacements
    // of cages and the environment use textures; it does not matter whether a node shows them. So the parts of a level go in
    // this order: nodes, cages, materials, textures. What a removed clip has posed stays until the next pose(). Each
    // renderer gives back what it keeps of removed and replaced things when its next frame begins, and each query in its
    // next begin().
    CageId add(Cage cage);  ///< sanitizes; see sanitize()
    CageId add(OnDemandCage cage);
    MaterialId add(Material material);
    TextureId add(Texture texture);
    LightId add(Light light);
    CameraId add(CameraLens lens);
    SkinId add(Skin skin);
    ClipId add(Clip clip);
    void remove(CageId id);
    void remove(MaterialId id);
    void remove(TextureId id);
    void remove(LightId id);
    void remove(CameraId id);
    void remove(SkinId id);
    void remove(ClipId id);
    const CageSlot& cage(CageId id) const;
    const Material& material(MaterialId id) const;
    const Texture& texture(TextureId id) const;
    const Light& light(LightId id) const;
    const CameraLens& camera_lens(CameraId id) const;
    const Skin& skin(SkinId id) const;
    const Clip& clip(ClipId id) const;
    void write_vertices(CageId id, std::span<const Vec3f> positions);  ///< as many as before; not of an OnDemandCage
    void replace(CageId id, Cage cage);                                ///< new topology
    void replace(MaterialId id, Material material);
    void replace(TextureId id, Texture texture);  ///< with the same path, the file is read again
    void replace(LightId id, Light light);
    void replace(CameraId id, CameraLens lens);

    // Lookups for the engine, which return null for a dead handle and do not throw.
    const Node* find(NodeId id) const noexcept;
    const CageSlot* find(CageId id) const noexcept;
    const Material* find(MaterialId id) const noexcept;
    const Texture* find(TextureId id) const noexcept;
    /// Returns the texture as it is now, which no edit changes; null for a dead handle.
    std::shared_ptr<const Texture> share(TextureId id) const noexcept;
    const Light* find(LightId id) const noexcept;
    const SkinSlot* find(SkinId id) const noexcept;
    const Clip* find(ClipId id) const noexcept;

    const std::vector<ClipId>& clips() const noexcept;  ///< in file order
    /// Returns the clips that are meant to play together: the first one, and each later one that moves no node that an
    /// earlier one of them moves. Blender, for instance, writes one clip for each object.
    std::vector<ClipId> clips_together() const;
    std::vector<TextureId> texture_ids() const;  ///< in the order in which they were added
    /// Returns whether materials that mask or blend have the texture as their base colour, and nothing else uses it.
    bool is_cut_out_by(TextureId id) const noexcept;
    Environment environment;

    /// Returns the camera of that name, or the first one if the name is empty, in world axes; those whose nodes were added
    /// earlier come first. It has keys if its node moves while the shutter is open.
    std::optional<Camera> camera(std::string_view name = {}) const;
    std::vector<std::string> camera_names() const;
    /// Returns the camera of that node; none if it has none, or it was removed.
    std::optional<Camera> camera_of(NodeId id) const;

    /// Returns the bounds of all that is visible, in world axes. It refits first.
    Box3d bounds();
    /// Brings dirty bounds up to date and returns the number of nodes and boxes it visited. A node on a dirty path visits
    /// its children; a node with many visits about 16 for each that changed, and twice the logarithm of their number.
    std::size_t refit();
    /// Returns how many users, and slots of materials, edits and refits have looked at so far; for tests.
    std::size_t looked_at() const noexcept;

    /// Calls visit(NodeId, const Node&, const Mat4d& world_from_node) for every placement in the graph that is visible at
    /// any time while the shutter is open, with its matrix in the pose that the scene is in. It visits parents first and
    /// follows instances too, whether or not the node that they show is visible itself (there are no cycles, because every
    /// edit that would make one is refused). If visit returns a bool, false leaves out what is below the placement.
    /// Instances of instances may be more than can be visited.
    template <class Visit>
    void for_each_placement(Visit&& visit) const;
    /// Returns what is visible in the whole scene. After refit() the cost is constant, otherwise it is a visit to all nodes.
    Contents contents() const;
    /// Calls visit for the placements that themselves hold one of these kinds of Contents, in the order of
    /// for_each_placement(). After refit() it visits only subtrees that hold one.
    /// shown   whether it visits what is visible at any time while the shutter is open, or what is in its middle
    using VisitPlacement = std::function<void(NodeId, const Node&, const Mat4d& world_from_node)>;
    enum class Shown : std::uint8_t { InShutter, MidShutter };
    void for_placements_of(Contents::Kinds kinds, const VisitPlacement& visit, Shown shown = Shown::InShutter) const;
    /// Returns the tree over the node's children, or null for a node with few of them. It is valid after refit().
    const ChildBoxes* child_boxes(NodeId id) const noexcept;
    /// Returns the number of a node's children.
    std::size_t child_count(NodeId id) const;

    struct Counts {
        std::size_t nodes = 0, cages = 0, faces = 0, lights = 0, cameras = 0;
        std::size_t materials = 0, textures = 0, clips = 0, skins = 0;
        std::size_t mesh_triangles = 0;  ///< those of `faces` that belong to triangle meshes
    };
    Counts counts() const;  ///< `faces` counts each cage once; see placed_faces()
    std::size_t placed_faces() const;

    /// Lists what was repaired or dropped when content was added: one line each, with a count. An application that adds
    /// content without end should clear it.
    std::vector<std::string> warnings;
    /// Lists what the importer chose where the file leaves a choice, such as whether polygons are subdivided: one line each.
    /// An application that adds content without end should clear it, too.
    std::vector<std::string> notes;
    /// Lists the files that the scene was read from, and those that they name if these are there, used or not: libraries,
    /// buffers, images. An application may watch them, and must not write over them. Those of a part stay when it is
    /// removed.
    std::vector<std::filesystem::path> files;
    /// The names under which the file offers alternative materials (KHR_materials_variants).
    std::vector<std::string> variants;

    /// While a FrameLock exists, edits throw.
    class FrameLock {
    public:
        explicit FrameLock(const Scene& scene);
        ~FrameLock();
        FrameLock(const FrameLock&) = delete;
        FrameLock& operator=(const FrameLock&) = delete;

    private:
        const Scene& scene_;
    };

private:
    friend CageId add_with_foreign_texture(Scene& scene, Cage cage);  // for verify/ (scenegraph/foreign_texture.h)

    struct State;
    std::shared_ptr<State> state_;  ///< of this scene alone, but for record_shutter() while it runs
};

template <class Visit>
void Scene::for_each_placement(Visit&& visit) const
{
    struct Place {
        NodeId id;
        Mat4d world_from_node;
    };
    std::vector<Place> todo;
    if (node(root()).is_visible_in_shutter()) todo.push_back({root(), node(root()).parent_from_node});
    while (!todo.empty()) {
        const Place place = todo.back();
        todo.pop_back();
        const Node& n = node(place.id);
        if constexpr (std::is_same_v<decltype(visit(place.id, n, place.world_from_node)), bool>) {
            if (!visit(place.id, n, place.world_from_node)) continue;
        } else {
            visit(place.id, n, place.world_from_node);
        }
        for (auto child = n.children.rbegin(); child != n.children.rend(); ++child)
            if (const Node* c = find(*child); c && c->is_visible_in_shutter())
                todo.push_back({*child, place.world_from_node * c->parent_from_node});
        if (find(n.instance_of)) todo.push_back({n.instance_of, place.world_from_node});
    }
}

}  // namespace occam
