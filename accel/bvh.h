// A lazily grown, multiscale tree of boxes over a scene's items, with eight children a node (a "bounding volume hierarchy").
//
// It serves the same rays as the kd-tree (accel/kd_tree.h), and a ray meets the same hits in either tree. Like there, a node
// starts lazy, as a list of items. For the pairs of levels that rays ask it for it is a leaf, or it is interior for them and
// all finer ones: then it has up to eight children, and a bound on the pairs for which their boxes are right; rays of
// coarser pairs meet it as a leaf. Each item lies in one child, whose box holds it whole.
//
// A node opens its items until there are enough to choose from (Hunt et al. 2007), and divides them at the cheapest of fixed
// planes between their middles (Wald 2007), the largest part first, until there are eight parts.
//
// Where things move, a node has the boxes of its children at several keys of an interval of the shutter, linear between
// them. Where they would grow much more than the items themselves, because neighbours part, a node divides its interval
// instead: it has a child for either half (accel/README.md).
//
// Memory   An arena; nodes never move. A lazy node's list stays behind when the node is expanded.
// Threads  One worker's own, or several workers', which read what exists without a lock and expand it under one
//          (`building`). A node is written before the link that leads to it.
#pragma once

#include <array>

#include "accel/build_lock.h"
#include "accel/candidates.h"
#include "base/publish.h"

namespace occam::accel {

struct BvhNode;

/// Holds what a lazy node was made from.
struct BvhRecord {
    std::span<const ItemIndex> items;
    int depth;
    float begin = 0, end = 1;  ///< the part of the shutter whose rays use the node
};

struct BvhLeaf : TreeLeaf {
    BvhLeaf* next = nullptr;  ///< the node's next leaf, for other pairs
    const BvhRecord* record = nullptr;
};

/// Holds the state of a node at one moment: a BvhNode, or a list of leaves.
class BvhState {
public:
    explicit BvhState(std::uintptr_t bits) : bits_(bits) {}

    bool is_interior() const noexcept { return (bits_ & 1) != 0; }
    BvhNode& node() const noexcept { return *reinterpret_cast<BvhNode*>(bits_ & ~std::uintptr_t(1)); }
    BvhLeaf& leaf() const noexcept { return *reinterpret_cast<BvhLeaf*>(bits_); }

    static std::uintptr_t of(BvhNode& node) noexcept { return reinterpret_cast<std::uintptr_t>(&node) | 1; }
    static std::uintptr_t of(BvhLeaf& leaf) noexcept { return reinterpret_cast<std::uintptr_t>(&leaf); }

private:
    std::uintptr_t bits_;
};

/// Holds a node's place in its parent, where its state is published.
struct BvhLink {
    std::uintptr_t bits = 0;

    BvhState state() const noexcept { return BvhState(read_published(bits)); }
};

/// An interior node. The boxes of its children follow it in memory, one group in the layout of BoxTree for each key.
struct alignas(Arena::kAlign) BvhNode {
    static constexpr int kWidth = BoxTree::kGroup;

    BvhLink children[kWidth];
    BvhLeaf* leaf = nullptr;  ///< the first leaf, for coarser pairs than `level`; published
    int level = 0;            ///< the node is interior for pairs up to this one
    int count = 0;            ///< number of children; the other boxes are empty
    KeySpan keys{};
    /// At least 0: the node has two children without boxes, for times up to this one and from this one on.
    float halved_at = -1;
    /// What may be seen of each child, as Items::visible_segments; null: all of them at all times.
    const std::uint32_t* visible_in = nullptr;

    bool is_halved() const noexcept { return halved_at >= 0; }
    const float* boxes() const noexcept { return reinterpret_cast<const float*>(this + 1); }
    /// Returns the children of which something may be seen in any of these segments of the shutter, as bits.
    unsigned seen_in(std::uint32_t segments) const noexcept
    {
        unsigned seen = 0;
        for (int i = 0; i < count; ++i) seen |= unsigned((visible_in[i] & segments) != 0) << i;
        return seen;
    }
};

class Bvh {
public:
    static constexpr int kMaxDepth = 48;

    /// building   is locked while the tree grows; null if no other thread reads the tree.
    /// segments   of the shutter; 0: nothing moves
    Bvh(Items& items, Arena& arena, TraceCounters& counters, int segments, Building* building);

    /// Makes one lazy node with these items. It is called after the arena was reset.
    void restart(std::span<const ItemIndex> roots);
    /// Expands every node as if rays of the pair entered it.
    void expand_all(int pair);

    BvhLink* root() noexcept { return &root_; }
    /// Returns the newest leaf of a node, or a leaf that holds for no pair if there is none yet.
    TreeLeaf& latest_leaf(const BvhLink* at) const noexcept { return *first_leaf(at->state()); }
    /// Returns what rays of a pair meet at a node that is not interior for it; it is made if needed. Returns null if the
    /// node has become interior.
    TreeLeaf* leaf(BvhLink* at, int pair)
    {
        BvhLeaf* known = find_leaf(at->state(), pair);
        return known ? known : expand(at, pair);
    }

private:
    /// Holds the candidates [begin, end) as one part.
    struct Part {
        std::size_t begin, end;
        Box3f box;
        float area;
    };

    static BvhLeaf* first_leaf(BvhState state) noexcept
    {
        return state.is_interior() ? read_published(state.node().leaf) : &state.leaf();
    }
    static BvhLeaf* find_leaf(BvhState state, int pair) noexcept
    {
        for (BvhLeaf* at = first_leaf(state); at; at = at->next)
            if (at->pairs.has(pair)) return at;
        return nullptr;
    }
    BvhLeaf* expand(BvhLink* at, int pair);
    void open_enough();
    bool is_leaf() const noexcept;
    BvhLeaf* make_leaf(BvhLink* at, BvhState state, const BvhRecord* record);
    BvhNode& new_node(BvhLeaf* leaf, int keys);
    void make_node(BvhLink* at, BvhLeaf* leaf, const BvhRecord& record);
    void make_halved_node(BvhLink* at, BvhLeaf* leaf, const BvhRecord& record);
    BvhLeaf* make_lazy(const BvhRecord& record);
    /// Returns the keys of boxes for candidates in a node.
    KeySpan keys_of(const BvhRecord& record) const noexcept;
    /// Writes the boxes at all keys of the candidates [begin, end) as one, at a place among groups of boxes.
    void set_boxes(float* boxes, std::size_t stride, std::size_t place, const KeySpan& keys, std::size_t begin,
                   std::size_t end) const;
    /// Notes what may be seen of the parts, if that is not all of them at all times.
    void note_visibility(BvhNode& node);
    /// Returns whether the parts' boxes grow so much over the interval that it is better to halve it.
    bool grows(const BvhRecord& record) const;
    /// Fills parts_ with all candidates, divided.
    void divide();
    void add_part(std::size_t begin, std::size_t end);
    /// Reorders the candidates of a part and returns where its second half begins.
    std::size_t halve(const Part& part);

    Items& items_;
    Arena& arena_;
    TraceCounters& counters_;
    int segments_;
    Building* building_;
    BvhLink root_;
    Candidates candidates_;
    std::array<Part, BvhNode::kWidth> parts_;
    int part_count_ = 0;
};

}  // namespace occam::accel
