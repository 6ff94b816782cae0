// What a kd-tree's lazy nodes hold: parts of the scene, each with a box, opened step by step as rays come near.
//
// An item stands for everything below it (Hunt et al. 2007): a node of the scene graph, a cluster of a cage's faces, a part of a
// large patch. Opening one makes its parts, once; what cannot be opened becomes an igrid when a ray enters its box.
//
// Space    boxes: the tree's frame (world axes, translated by the frame's anchor), grown to hold what they stand for for sure.
// Memory   one worker's arena.   Threads  one worker's own.
#pragma once

#include "accel/igrid.h"
#include "accel/frame_state.h"
#include "accel/tracer.h"
#include "scenegraph/base/arena.h"

namespace occam::accel {

using ItemIndex = std::uint32_t;

/// A node of the scene graph at one of its places.
struct PlacedNode {
    NodeId id;
    Mat4d world_from_node;
    std::uint64_t key;  ///< of the path
    const PlacedNode* parent;
    int depth;
};

struct Item {
    enum Kind : std::uint8_t {
        SceneNode,   ///< subject: PlacedNode
        Cluster,     ///< subject: PosedCage, index: node of its ClusterTree
        Patch,       ///< part of a patch, too large for one tile
        Tile,        ///< final: one tile of a patch
        SmallPatches,  ///< final: small patches of a cluster
        Faces        ///< final: triangles of a cluster
    };
    static constexpr std::uint32_t kClosed = ~0u;

    Box3f box;
    Kind kind = SceneNode;
    float cost = 1;                  ///< of meeting it, in traversal steps
    std::uint32_t first_part = kClosed;
    std::uint32_t part_count = 0;
    const void* subject = nullptr;   ///< PlacedNode or PosedCage
    std::uint32_t index = 0;         ///< cluster node; or count of tiles
    const lod::TileRef* tiles = nullptr;
    IGrid* grid = nullptr;           ///< final kinds, once built

    bool is_final() const noexcept { return kind >= Tile; }
    const lod::PosedCage& cage() const noexcept { return *static_cast<const lod::PosedCage*>(subject); }
};

class Items {
public:
    Items(const FrameState& frame, Arena& arena, lod::Dicer& dicer, TraceCounters& counters);

    /// Forgets everything and makes the root item again; call after the arena was reset.
    ItemIndex restart();

    Item& operator[](ItemIndex i) noexcept { return items_[i]; }

    /// Makes the parts of an item that is not final; [first_part, first_part + part_count) afterwards. Items may move in memory.
    void open(ItemIndex i);
    /// The igrid of a final item, built now if this is the first ray in its box.
    IGrid& grid(ItemIndex i);

private:
    void open_node(const PlacedNode& node);
    void open_cluster(const lod::PosedCage& cage, std::uint32_t cluster);
    void open_patch(const lod::PosedCage& cage, const lod::TileRef& part);
    void add_cage(const PlacedNode& at, const Node& node, CageId id, std::size_t place);
    void add_patch_part(const lod::PosedCage& cage, const lod::TileRef& part);
    Box3f box_of(const lod::PosedCage& cage, const Box3f& object_box) const;
    Box3f to_tree(const lod::PosedCage& cage, const Box3f& box) const;

    const FrameState& frame_;
    Arena& arena_;
    lod::Dicer& dicer_;
    TraceCounters& counters_;
    IGridBuilder builder_;
    ArenaVector<Item> items_;
    std::vector<lod::TileRef> small_;
};

}  // namespace occam::accel
