// A lazily grown multiscale kd-tree over a scene's items (Djeu et al. 2011, sec. 5.2.1-5.2.2).
//
// A node starts lazy: a box and a list of items. Rays that enter it ask for pairs of levels (lod/ray_levels.h). For these
// pairs it becomes a leaf, or it becomes interior for them and all finer ones. Then it has a plane, and a bound on the pairs
// for which the boxes below it are right and the parts that were left out lie beside it; for rays of coarser pairs it is a
// leaf. So a node may be a leaf for many pairs, with a list of igrids for each. No leaf serves a pair at which a part that
// was left out may reach into it.
//
// The plane comes from the surface area heuristic, scanned at fixed steps where there are many boxes (Hunt et al. 2006)
// and tried at all their ends where there are few, after opening large items until there are enough to choose from
// (Hunt et al. 2007). The tree's shape depends on which pairs come first; the hits of rays do not.
//
// Memory   An arena; a lazy node's list stays behind when the node is expanded.
// Threads  One worker's own, or several workers', which read what exists without a lock and expand it under one
//          (`building`). A node is written before the link that leads to it.
#pragma once

#include "accel/build_lock.h"
#include "accel/candidates.h"

namespace occam::accel {

/// Holds the state of a node at one moment.
struct KdLink {
    std::uint32_t bits;  ///< 0-1: axis of an interior node, 3: none. Interior: 2-8: level, 9-31: pair of children

    static constexpr std::uint32_t kMaxPairs = 1u << 23;
    static constexpr int kAllLevels = 127;

    bool is_interior() const noexcept { return (bits & 3) != 3; }
    int axis() const noexcept { return static_cast<int>(bits & 3); }
    /// The node is interior for pairs up to this one (kAllLevels: for all pairs).
    int level() const noexcept { return static_cast<int>(bits >> 2 & 127) + lod::kFinestLevel - 1; }
    std::uint32_t first_child() const noexcept { return bits >> 9 << 1 | 1; }
    std::uint32_t leaf() const noexcept { return bits >> 2; }

    static KdLink to_leaf(std::uint32_t leaf) noexcept { return {leaf << 2 | 3}; }
    static KdLink to_children(int axis, int level, std::uint32_t pair) noexcept
    {
        const int code = std::clamp(level - lod::kFinestLevel + 1, 0, 127);
        return {pair << 9 | static_cast<std::uint32_t>(code) << 2 | static_cast<std::uint32_t>(axis)};
    }
};

struct KdNode {
    float split;         ///< position, once the link is an interior node's
    std::uint32_t bits;  ///< of the link

    KdLink link() const noexcept { return {read_published(bits)}; }
};
static_assert(sizeof(KdNode) == 8);  // eight a cache line

/// A leaf of the kd-tree.
struct KdLeaf : TreeLeaf {
    std::uint32_t next = 0;  ///< the node's next leaf, for other pairs; 0: none
    std::uint32_t record = 0;
};

class KdTree {
public:
    static constexpr int kMaxDepth = 60;

    /// may_scan   allows planes at fixed steps where there are many boxes.
    /// building   is locked while the tree grows; null if no other thread reads the tree.
    KdTree(Items& items, Arena& arena, TraceCounters& counters, bool may_scan, Building* building);

    /// Makes one lazy node with these items. It is called after the arena was reset.
    void restart(const Box3f& bounds, std::span<const ItemIndex> roots);
    /// Expands every node as if rays of the pair entered it.
    void expand_all(int pair);

    const KdNode& node(std::uint32_t n) const noexcept { return nodes_[n]; }
    /// Returns the newest leaf of a node, or a leaf that holds for no pair if there is none yet.
    KdLeaf& latest_leaf(std::uint32_t n) noexcept { return leaves_[head_of(n)]; }
    /// Returns the leaf of a node for a pair for which the node is not interior; it is made if needed. Returns null if the
    /// node has become interior.
    KdLeaf* leaf(std::uint32_t n, int pair)
    {
        KdLeaf* known = find_leaf(n, pair);
        return known ? known : expand(n, pair);
    }

private:
    class BoxMeasure;
    struct Record {
        Box3f box;
        std::span<const ItemIndex> items;
        int depth;
    };
    struct Event {
        float position, cost;
    };
    struct Split {
        int axis = -1;
        float position = 0, cost = 0;
    };

    /// Returns the first of a node's leaves: it is where the link says or, for an interior node, beside its children.
    std::uint32_t head_of(std::uint32_t n) const noexcept
    {
        const KdLink at = nodes_[n].link();
        return at.is_interior() ? read_published(heads_[at.first_child() >> 1]) : at.leaf();
    }
    KdLeaf* find_leaf(std::uint32_t n, int pair) noexcept
    {
        for (std::uint32_t at = head_of(n); at != 0; at = leaves_[at].next)
            if (leaves_[at].pairs.has(pair)) return &leaves_[at];
        return nullptr;
    }
    KdLeaf* expand(std::uint32_t n, int pair);
    KdLeaf* make_leaf(std::uint32_t n, std::uint32_t head, std::uint32_t record);
    Split best_split(const Box3f& box);
    // Tries the planes at the faces of boxes: counted_split() tests each against all boxes, and swept_split() goes through
    // them in sorted order, which is faster for many boxes.
    Split counted_split(const Box3f& box);
    // Tries the planes of so many vectors of planes_, from planes_[first] on, keeps the best split, and returns how many
    // planes these are.
    template <int kVectors>
    std::size_t try_planes(const Box3f& box, const BoxMeasure& measure, int axis, std::size_t first, Split& best) const;
    Split swept_split(const Box3f& box);
    // Tries planes at fixed steps.
    Split scanned_split(const Box3f& box) const;
    void make_lazy(const Box3f& box, int depth, int axis, float position, bool upper);

    Arena& arena_;
    TraceCounters& counters_;
    bool may_scan_;
    Building* building_;
    ArenaVector<KdNode> nodes_;  ///< the root is 0; the children of a node lie side by side, the first at an odd number
    ArenaVector<std::uint32_t> heads_;  ///< for each pair of children, the first leaf of the parent
    ArenaVector<Record> records_;
    ArenaVector<KdLeaf> leaves_;  ///< entry 0 is not used, since KdLeaf::next is 0 at the end of a list
    Candidates candidates_;
    std::vector<Event> low_events_, high_events_;
    std::vector<float> planes_;
};

}  // namespace occam::accel
