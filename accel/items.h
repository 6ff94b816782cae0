// Holds what the lazy nodes of a tree list: parts of the scene, each with a box, opened step by step as rays come near.
//
// An item represents everything below it (Hunt et al. 2007): a node of the scene graph, a cluster of a cage's faces, a
// patch, or a dyadic region of a patch. An item knows only two bounds on levels: the pair from which on rays see it as one
// igrid, and the pair up to which its box holds that igrid. So one tree serves all pairs (Djeu et al. 2011, sec. 5.2.1).
//
// Space    Boxes are in the tree's frame (world axes, translated by the frame's anchor), grown to hold their contents
//          conservatively.
// Memory   The arena of the tree.
// Threads  One thread at a time: the owner of the tree, or the worker that holds the lock of a shared tree.
#pragma once

#include <algorithm>
#include <limits>
#include <string>

#include "accel/frame_state.h"
#include "accel/grid_table.h"
#include "accel/lattice_builder.h"
#include "accel/mesh_builder.h"
#include "accel/trace_counters.h"
#include "base/arena.h"

namespace occam::accel {

using ItemIndex = std::uint32_t;

/// A node of the scene graph in one of its placements.
struct PlacedNode {
    NodeId id;
    Mat4d world_from_node;
    lod::GraphPath path;
    const PlacedNode* parent;
    NodeId instance;                   ///< the last node on the path that shows the next one by instance_of; null: none does
    std::uint8_t seen_by;              ///< follows from all nodes on the path
    LightGroups lit_by;                ///< follows from all nodes on the path
    std::span<const Mat4d> at_keys{};  ///< world_from_node at each key of the scene's shutter; empty: it stands still
    std::uint32_t visible_in = lod::PosedCage::kAllSegments;  ///< by the path, as in PosedCage

    /// Returns world_from_node at each key, or once.
    std::span<const Mat4d> matrices() const noexcept
    {
        return at_keys.empty() ? std::span<const Mat4d>(&world_from_node, 1) : at_keys;
    }
};

/// A box in the tree's frame, of something that may move.
struct ShutterBox {
    Box3f box;                       ///< at all times
    const Box3f* at_keys = nullptr;  ///< the same at each key of the scene's shutter; null: `box` stands for all
};

inline constexpr float kBoxUlps = 4;  // boxes of items grow by two ulps for their rounding and two for the culling rule

/// Tells by how much a box at a key grows, so that boxes that are linear between keys hold what they should: what lies
/// between keys is rounded to ulps of where it is, and of where the key before it is.
class GrowthAtKeys {
public:
    /// Returns the growth of the box at the next key. Empty boxes count as one at the origin.
    float next(const Box3f& box) noexcept
    {
        const float before = largest_;
        largest_ = box.is_empty() ? 0 : box.largest_coordinate();
        return std::max(before, largest_) * kBoxUlps * std::numeric_limits<float>::epsilon();
    }

private:
    float largest_ = 0;
};

/// A patch of a cage whose rates are known. The box holds the whole patch.
struct PatchInfo : ShutterBox {
    lod::PatchRef ref;
    lod::PatchScale scale;
};

/// Holds the patches of a leaf of a cage's cluster tree.
struct ClusterInfo {
    std::span<PatchInfo> patches;
    int small_from = lod::kFinestLevel;  ///< from this level on all patches are small: they share an igrid
    int same_from = lod::kFinestLevel;   ///< from this level on no patch changes any more
};

struct Item : ShutterBox {
    enum Kind : std::uint8_t {
        SceneNode,  ///< subject: PlacedNode
        Children,   ///< subject: PlacedNode, index: node of its ChildBoxes
        Unmade,     ///< subject: PlacedNode, index: which of its cages; the cage is made on demand
        Cluster,    ///< subject: PosedCage, index: node of its ClusterTree
        Leaf,       ///< the same, without nodes below
        Region,     ///< a patch or part of one
        Faces       ///< triangles of a cluster of a mesh
    };
    static constexpr std::uint32_t kClosed = ~0u;
    static constexpr std::int8_t kNever = 127, kAlways = -128;

    Kind kind = SceneNode;
    std::int8_t final_from = kNever;  ///< rays of this pair and of coarser ones see the item as one igrid
    std::int8_t holds_to = kNever;    ///< the box is right for pairs up to this one
    float cost = 1;                   ///< cost of intersecting it, in traversal steps
    std::uint32_t first_part = kClosed;
    std::uint32_t part_count = 0;
    const void* subject = nullptr;     ///< PlacedNode or PosedCage
    std::uint32_t index = 0;           ///< cluster node
    ClusterInfo* cluster = nullptr;    ///< Leaf, once measured; Region
    const PatchInfo* patch = nullptr;  ///< Region
    lod::PatchRegion region;           ///< Region

    const lod::PosedCage& cage() const noexcept { return *static_cast<const lod::PosedCage*>(subject); }
};

class Items {
public:
    /// splits_in_space   whether triangles of meshes may be cut
    Items(const FrameState& frame, Arena& arena, lod::Dicer& dicer, TraceCounters& counters, bool splits_in_space);

    /// Forgets everything and makes the root item again. It is called after the arena was reset.
    ItemIndex restart();
    /// Opens all nodes and clusters after restart(). Every base patch is left, and triangles in clusters.
    std::vector<ItemIndex> base_patches();

    Item& operator[](ItemIndex i) noexcept { return items_[i]; }

    bool is_final(ItemIndex i, int pair) const noexcept { return pair_of(items_[i], pair) >= items_[i].final_from; }
    /// Returns what opening the item costs: 0 looks at no vertex, 1 makes or poses vertices, 2 divides a region.
    int effort(ItemIndex i) const noexcept
    {
        switch (items_[i].kind) {
            case Item::Unmade:
            case Item::Leaf:
                return 1;
            case Item::Region:
                return 2;
            case Item::SceneNode:
            case Item::Children:
            case Item::Cluster:
            case Item::Faces:
                break;
        }
        return 0;
    }

    /// Names the node that an item belongs to, for a message.
    std::string name_of(ItemIndex i) const;
    /// Names the node or mesh to which most items belong.
    std::string name_of_largest() const;

    /// Makes the parts of an item that is not final: [first_part, first_part + part_count) afterwards. For a Leaf that
    /// was not examined yet, it finds the pair from which on it is final. Returns whether
    /// there are parts.
    bool open(ItemIndex i, int pair);
    /// Returns the igrid that rays of a pair see in the item, which is final for that pair. It is built now if this is
    /// the first request.
    IGrid& grid(ItemIndex i, int pair);
    /// Returns the bounds of such an igrid in the tree's frame; they are tighter than the item's box.
    GridBounds bounds_of(const IGrid& grid) const;
    /// Returns a box, in the tree's frame, that holds such an igrid at a moment of the shutter: between its keys, the box
    /// that lies between those at the keys. Rounding between moments is not in it.
    Box3f box_at(const IGrid& grid, float time) const;
    /// Returns whether rays may pass some surface of an item's igrid while they are traced (accel/holes.h).
    bool may_have_holes(const Item& item, bool is_shared) const noexcept;
    /// Returns boxes that hold an item at the keys of the scene's shutter; between keys it is in the box that lies between
    /// them. They are empty if the item's one box stands for all times.
    std::span<const Box3f> key_boxes(ItemIndex i) const noexcept
    {
        const Item& item = items_[i];
        return item.at_keys ? std::span(item.at_keys, std::size_t(frame_.segments) + 1) : std::span<const Box3f>();
    }
    /// Returns a mask whose bit k tells whether anything of the item may be seen in segment k of the scene's shutter.
    std::uint32_t visible_segments(ItemIndex i) const noexcept
    {
        const Item& item = items_[i];
        const bool is_node = item.kind == Item::SceneNode || item.kind == Item::Children || item.kind == Item::Unmade;
        return is_node ? static_cast<const PlacedNode*>(item.subject)->visible_in : item.cage().visible_in;
    }
    /// Returns the pairs for which that igrid is the same.
    PairRange range(ItemIndex i, int pair) const noexcept;

private:
    int pair_of(const Item& item, int pair) const noexcept
    {
        return frame_.levels.mode != lod::LevelMode::PerInstance || item.kind < Item::Leaf ? pair : item.cage().level;
    }
    void open_node(const PlacedNode& node);
    /// Where and when a node is seen; the fields are as in PlacedNode.
    struct Placement {
        Mat4d world_from_node;
        std::span<const Mat4d> at_keys;
        std::uint32_t visible_in;
    };
    /// Adds a child of a placed node, or what is placed there by instance_of.
    /// place   as GraphPath::place
    void add_placed(const PlacedNode& parent, NodeId id, const Placement& placement, std::uint64_t place);
    void add_child(const PlacedNode& parent, NodeId id);
    void add_children(const PlacedNode& parent, const ChildBoxes& boxes, std::uint32_t at);
    void open_children(const PlacedNode& parent, std::uint32_t at);
    void open_cluster(const lod::PosedCage& cage, std::uint32_t cluster);
    void add_cluster(const lod::PosedCage& cage, std::uint32_t cluster);
    void measure(ItemIndex leaf);
    /// Sets the boxes of a patch, and adds those at the keys of the cage's motion, in the dicing frame, to `all`.
    void set_bounds(PatchInfo& patch, const lod::PosedCage& cage, Box3f* all);
    void add_region(const lod::PosedCage& cage, ClusterInfo* cluster, const PatchInfo& patch,
                    const lod::PatchRegion& region);
    void open_region(const Item& item);
    void add_cage(const PlacedNode& at, const Node& node, CageId id, std::size_t place);
    /// Builds the igrid of the item's triangles, of all patches of its cluster if `is_shared`, or of the tile.
    IGrid* build(const Item& item, const GridSubject& of, bool is_shared, const lod::TileRef& tile);
    /// Returns the level of the fine positions of the igrid that an item has for these pairs.
    int level_of(const Item& item, PairRange pairs) const noexcept;
    bool shares(const Item& item, int pair) const noexcept;
    bool may_share(const Item& item) const noexcept;
    /// Returns how a child is placed: at each key, if the placement of either moves; else empty.
    std::span<const Mat4d> child_at_keys(const PlacedNode& parent, const Node& child);
    /// Sets boxes to those at moments that divide the shutter evenly, or to one that stands for all times.
    void set_boxes(ShutterBox& to, std::span<const Box3f> own);
    /// Sets boxes to box_at(key) for each key of a cage.
    template <class BoxAt>
    void set_boxes_at_keys(ShutterBox& to, const lod::PosedCage& cage, BoxAt&& box_at)
    {
        Box3f own[lod::kMostSegments + 1];
        for (int key = 0; key <= cage.segments; ++key) own[key] = box_at(key);
        set_boxes(to, {own, static_cast<std::size_t>(cage.segments) + 1});
    }
    Box3f box_of(const lod::PosedCage& cage, std::uint32_t cluster) const;
    void set_box_of_node(Item& item, const PlacedNode& at, const Box3d& bounds);
    /// Takes a box from the dicing frame that a cage has at a key of its motion.
    Box3f to_tree(const lod::PosedCage& cage, int key, const Box3f& box) const;
    Box3f to_tree(const Box3d& world, double pad) const;
    /// Returns the box of the image of a still pose's igrid.
    Box3f image_in_tree(const IGrid& grid, const lod::AffinePose& pose) const;

    const FrameState& frame_;
    Arena& arena_;
    lod::Dicer& dicer_;
    TraceCounters& counters_;
    LatticeBuilder lattices_;
    MeshBuilder meshes_;
    ArenaVector<Item> items_;
    GridTable grids_;
    std::vector<LatticeBuilder::PatchTile> parts_;
};

}  // namespace occam::accel
