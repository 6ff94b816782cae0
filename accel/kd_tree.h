// A lazily grown kd-tree over a scene's items: one worker's own (Djeu et al. 2011, sec. 5.2.1-5.2.2).
//
// A node starts lazy: a box and a list of items. The first ray that enters it makes it interior or a leaf, by the surface area
// heuristic swept over the items' boxes (Hunt et al. 2006), after opening large items until there are enough to choose from
// (Hunt et al. 2007). What a node becomes depends on its box and items alone, so the tree has the same shape whichever ray
// comes first; only what of it exists differs.
//
// Memory   one worker's arena; a lazy node's list stays behind when it is expanded.   Threads  one worker's own.
#pragma once

#include "accel/items.h"

namespace occam::accel {

struct KdNode {
    float split;         ///< interior: position; else unused
    std::uint32_t link;  ///< low two bits: axis of an interior node, 3: leaf or lazy; the rest: first child, or record

    bool is_interior() const noexcept { return (link & 3) != 3; }
    int axis() const noexcept { return static_cast<int>(link & 3); }
    std::uint32_t below() const noexcept { return link >> 2; }
};
static_assert(sizeof(KdNode) == 8);  // eight a cache line

class KdTree {
public:
    static constexpr int kMaxDepth = 60;

    KdTree(Items& items, Arena& arena, TraceCounters& counters);

    /// One lazy node with the root item; call after the arena was reset.
    void restart(const Box3f& bounds, ItemIndex root);

    const KdNode& node(std::uint32_t n) const noexcept { return nodes_[n]; }
    bool is_lazy(const KdNode& node) const noexcept { return !node.is_interior() && records_[node.below()].is_lazy; }
    std::span<const ItemIndex> leaf(const KdNode& node) const noexcept { return records_[node.below()].items; }

    /// Makes a lazy node interior or a leaf.
    void expand(std::uint32_t n);

private:
    struct Record {
        Box3f box;
        std::span<const ItemIndex> items;
        int depth;
        bool is_lazy;
    };
    struct Candidate {
        Box3f box;  ///< clipped to the node
        ItemIndex item;
        float cost;
        bool is_final;
    };
    struct Event {
        float position, cost;
    };
    struct Split {
        int axis = -1;
        float position = 0, cost = 0;
    };

    void clip_into(const Box3f& box, ItemIndex item);
    bool open_largest(const Box3f& box);
    Split best_split(const Box3f& box);
    std::uint32_t make_lazy(const Box3f& box, int depth, int axis, float position, bool upper);

    Items& items_;
    Arena& arena_;
    TraceCounters& counters_;
    ArenaVector<KdNode> nodes_;
    ArenaVector<Record> records_;
    std::vector<Candidate> candidates_;
    std::vector<Event> low_events_, high_events_;
};

}  // namespace occam::accel
