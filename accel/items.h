// Holds what a kd-tree's lazy nodes list: parts of the scene, each with a box, opened step by step as rays come near.
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

#include "accel/frame_state.h"
#include "accel/grid_table.h"
#include "accel/igrid.h"
#include "accel/tracer.h"
#include "base/arena.h"

namespace occam::accel {

using ItemIndex = std::uint32_t;

/// A node of the scene graph in one of its placements.
struct PlacedNode {
    NodeId id;
    Mat4d world_from_node;
    std::uint64_t key;  ///< hash of the path from the root
    const PlacedNode* parent;
    int depth;
    std::uint8_t seen_by;  ///< follows from all nodes on the path
    LightGroups lit_by;    ///< follows from all nodes on the path
};

/// A patch of a cage whose rates are known.
struct PatchInfo {
    lod::PatchRef ref;
    lod::PatchScale scale;
    Box3f box;  ///< holds the whole patch, in the dicing frame
};

/// Holds the patches of a leaf of a cage's cluster tree.
struct ClusterInfo {
    std::span<PatchInfo> patches;
    int small_from = lod::kFinestLevel;  ///< from this level on all patches are small: they share an igrid
    int same_from = lod::kFinestLevel;   ///< from this level on no patch changes any more
};

struct Item {
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

    Box3f box;
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
    Items(const FrameState& frame, Arena& arena, lod::Dicer& dicer, TraceCounters& counters);

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
            default:
                return 0;
        }
    }

    /// Makes the parts of an item that is not final: [first_part, first_part + part_count) afterwards. For a Leaf that
    /// was not examined yet, it finds the pair from which on it is final. Items may move in memory. Returns whether
    /// there are parts.
    bool open(ItemIndex i, int pair);
    /// Returns the igrid that rays of a pair see in the item, which is final for that pair. It is built now if this is
    /// the first request.
    IGrid& grid(ItemIndex i, int pair);
    /// Returns the bounds of such an igrid in the tree's frame; they are tighter than the item's box.
    GridBounds bounds_of(const IGrid& grid) const;
    /// Returns the pairs for which that igrid is the same.
    PairRange range(ItemIndex i, int pair) const noexcept;

private:
    int pair_of(const Item& item, int pair) const noexcept
    {
        return frame_.levels.mode != lod::LevelMode::PerInstance || item.kind < Item::Leaf ? pair : item.cage().level;
    }
    void open_node(const PlacedNode& node);
    /// Adds a child of a placed node, or what is placed there by instance_of.
    void add_placed(const PlacedNode& parent, NodeId id, const Mat4d& world, std::uint64_t place);
    void add_child(const PlacedNode& parent, NodeId id);
    void add_children(const PlacedNode& parent, const ChildBoxes& boxes, std::uint32_t at);
    void open_children(const PlacedNode& parent, std::uint32_t at);
    void open_cluster(const lod::PosedCage& cage, std::uint32_t cluster);
    void add_cluster(const lod::PosedCage& cage, std::uint32_t cluster);
    void measure(ItemIndex leaf);
    void add_region(const lod::PosedCage& cage, ClusterInfo* cluster, const PatchInfo& patch,
                    const lod::PatchRegion& region);
    void open_region(const Item& item);
    void add_cage(const PlacedNode& at, const Node& node, CageId id, std::size_t place);
    IGrid* build(const Item& item, int level, int coarser, bool is_shared, const lod::TileRef& tile);
    /// Returns the level of the fine positions of the igrid that an item has for these pairs.
    int level_of(const Item& item, PairRange pairs) const noexcept;
    bool shares(const Item& item, int pair) const noexcept;
    bool may_share(const Item& item) const noexcept;
    Box3f box_of(const lod::PosedCage& cage, std::uint32_t cluster) const;
    Box3f box_of_node(const Mat4d& world_from_node, const Box3d& bounds) const;
    Box3f to_tree(const lod::PosedCage& cage, const Box3f& box) const;
    Box3f to_tree(const Box3d& world, double pad) const;

    const FrameState& frame_;
    Arena& arena_;
    lod::Dicer& dicer_;
    TraceCounters& counters_;
    IGridBuilder builder_;
    ArenaVector<Item> items_;
    GridTable grids_;
    std::vector<IGridBuilder::PatchTile> parts_;
};

}  // namespace occam::accel
