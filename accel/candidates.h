// The items among which a lazy node of a tree chooses its children: they are opened, largest first, until there are enough.
//
// Both trees grow from items in the same way (accel/kd_tree.h, accel/bvh.h); what they make of them differs.
#pragma once

#include <vector>

#include "accel/tree_leaf.h"

namespace occam::accel {

struct Candidate {
    Box3f box;  ///< clipped to the node
    ItemIndex item;
    float cost;
    bool is_final;
};

class Candidates : public std::vector<Candidate> {
public:
    /// The largest effort of opening an item; see Items::effort.
    static constexpr int kAnyEffort = 2;

    explicit Candidates(Items& items) : items_(items) {}

    /// In place of a time, this value asks for boxes that hold items at all times.
    static constexpr float kAllTimes = -1;

    /// The most candidates of a node. So many lie in one place only if no plane parts them; more are an error.
    static constexpr std::size_t kMost = std::size_t(1) << 22;
    /// The most of those that move, if their boxes hold them at all times. Each has a box at every key, and a ray would meet
    /// the igrids of nearly all of them.
    static constexpr std::size_t kMostPassing = std::size_t(1) << 17;

    /// Starts with the parts of these items that lie in a node's box. Items that rays of the pair meet as one igrid are
    /// final.
    /// time   moment of the shutter at which the boxes of items that move are taken
    void start(const Box3f& box, std::span<const ItemIndex> items, int pair, float time = kAllTimes);
    /// Opens the largest of those items that cost the least effort to open. Returns false if there is none of at most
    /// `most_effort`. Throws Error if there are more than kMost, or kMostPassing.
    bool open_largest(int most_effort);
    /// Makes the list of a leaf, for the pairs to which it applies, with boxes that hold the items at all times. All
    /// candidates are final.
    /// keys   the keys of boxes that move, for which there is room; they are not written
    TreeLeaf leaf(Arena& arena, const KeySpan& keys = {}) const;
    /// Returns a box that holds an item at a moment of the shutter.
    Box3f box_at(ItemIndex item, float time) const noexcept;
    /// Returns what may be seen of any of the candidates [begin, end), as Items::visible_segments.
    std::uint32_t visible_in(std::size_t begin, std::size_t end) const noexcept;
    /// Returns whether any item moves.
    bool move() const noexcept;
    /// Returns the pair up to which all boxes are right: those of the candidates, and those of the parts that were left out
    /// because their boxes lie beside the node.
    int holds_to() const noexcept;

private:
    /// The number of candidates from which on those that may be opened are kept in a heap; fewer are searched one by one.
    static constexpr std::size_t kWorthAHeap = 256;

    /// A candidate that is not final, in the heap.
    struct Unopened {
        int effort;
        float area;
        std::uint32_t handle;
        /// Returns whether it is opened after another.
        bool operator<(const Unopened& other) const noexcept
        {
            if (effort != other.effort) return effort > other.effort;
            return area != other.area ? area < other.area : handle > other.handle;
        }
    };

    void add(ItemIndex item);
    void add_parts(ItemIndex item);
    /// Returns whether the item moves and its box holds it at all times.
    bool passes(ItemIndex item) const noexcept;
    void make_heap();
    void add_to_heap(std::size_t place);
    /// Returns the place of the largest of those candidates that cost the least effort to open, or size() if there is none
    /// of at most `most_effort`.
    std::size_t find_largest(int most_effort);
    void remove(std::size_t place);

    Items& items_;
    Box3f within_;
    int pair_ = 0;
    float time_ = kAllTimes;
    std::size_t passing_ = 0;         ///< candidates that pass through the node
    int left_out_to_ = Item::kNever;  ///< the pair up to which whatever was left out since start() is beside the node
    // The following are in use if has_heap_ is set. A handle is a candidate's number for as long as it is in the list.
    bool has_heap_ = false;
    std::vector<Unopened> heap_;
    std::vector<std::uint32_t> handle_at_, place_of_;  ///< by place, and by handle
};

}  // namespace occam::accel
