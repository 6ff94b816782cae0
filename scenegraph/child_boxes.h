// The boxes and contents of a node's many children in a tree, so that an edit of one child visits few of the others, and a
// ray or a search that looks for some of them does, too.
//
// This is a complete binary tree over blocks of kBlock children: an edit costs its block and one sum for each level above
// it. Children are put into blocks along a Morton curve through the middles of their boxes when the tree is made, and again
// when so many were edited since that the blocks have grown to twice their size. Children that are added meanwhile follow
// in the order of addition.
//
// Space    the axes of the boxes that are given: the parent's own.
// Memory   22 to 36 bytes a child.
// Threads  as Scene.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.h"
#include "scenegraph/contents.h"

namespace occam {

class ChildBoxes {
public:
    static constexpr std::size_t kBlock = 16;
    /// A node with more children than this is opened along the tree, a block of children at a time.
    static constexpr std::size_t kMostAtOnce = 256;

    /// Marks the child as out of date.
    void touch(std::size_t child)
    {
        ++edits_;
        if (child < block_of_.size()) touch_block(block_of_[child]);
    }
    /// Makes room for this many children; call it before refit(). If the capacity grows, or the children are to be put in a
    /// new order, all of them are out of date.
    void resize(std::size_t children);

    /// Calls visit(i) for every child that refit() will visit.
    template <class Visit>
    void for_each_stale(Visit&& visit) const
    {
        for (const std::uint32_t block : stale_)
            for (const std::uint32_t child : block_children(block)) visit(child);
    }
    /// Updates the tree and returns the number of sums it visited. box_of(i) returns a child's box, empty if it shows
    /// nothing, and contents_of(i) its contents.
    template <class BoxOf, class ContentsOf>
    std::size_t refit(BoxOf&& box_of, ContentsOf&& contents_of)
    {
        if (is_unsorted_) {
            std::vector<Box3d> boxes;
            boxes.reserve(order_.size());
            for (std::size_t i = 0; i < order_.size(); ++i) boxes.push_back(box_of(i));
            sort(boxes);
        }
        std::size_t looked_at = 0;
        for (const std::uint32_t block : stale_) {
            Sum sum;
            for (const std::uint32_t child : block_children(block)) sum.add({box_of(child), contents_of(child)});
            looked_at += block_children(block).size();
            store_block(block, sum);
        }
        return looked_at + refit_above();
    }
    const Box3d& bounds() const noexcept { return sums_[kRoot].box; }
    const Contents& contents() const noexcept { return sums_[kRoot].contents; }

    /// The nodes of the tree, for those who look for some of the children. All is valid after refit(). The children of node
    /// n are 2n and 2n + 1, unless it is a block.
    static constexpr std::uint32_t kRoot = 1;
    bool is_block(std::uint32_t node) const noexcept { return node >= leaves_; }
    const Box3d& box(std::uint32_t node) const noexcept { return sums_[node].box; }
    const Contents& contents(std::uint32_t node) const noexcept { return sums_[node].contents; }
    /// Returns the children of a node that is a block, by their index.
    std::span<const std::uint32_t> children(std::uint32_t node) const noexcept
    {
        return block_children(node - static_cast<std::uint32_t>(leaves_));
    }
    /// Returns the number of blocks at or below a node, empty ones included.
    std::size_t blocks_below(std::uint32_t node) const noexcept { return leaves_ >> (std::bit_width(node) - 1); }
    /// Returns how many things opening a node with that many children puts side by side, at most.
    static std::size_t most_at_once(std::size_t children) noexcept;
    /// Appends the children of the blocks that hold one of these kinds, by their index and in rising order.
    void find(Contents::Kinds kinds, std::vector<std::uint32_t>& out) const;

private:
    struct Sum {
        Box3d box;
        Contents contents;

        void add(const Sum& other) noexcept
        {
            box.add(other.box);
            contents.add(other.contents);
        }
    };

    std::span<const std::uint32_t> block_children(std::uint32_t block) const noexcept
    {
        const std::size_t first = std::min(block * kBlock, order_.size());
        return std::span(order_).subspan(first, std::min(kBlock, order_.size() - first));
    }
    void touch_block(std::uint32_t block)
    {
        if (is_stale_[block]) return;
        is_stale_[block] = true;
        stale_.push_back(block);
    }
    void store_block(std::uint32_t block, const Sum& sum) noexcept;
    void sort(const std::vector<Box3d>& boxes);
    std::size_t refit_above();

    std::size_t leaves_ = 0;  ///< capacity in blocks: a power of two
    std::vector<Sum> sums_;   ///< the root is 1, the children of n are 2n and 2n + 1, and the blocks start at leaves_
    std::vector<std::uint32_t> order_;     ///< the children, block after block
    std::vector<std::uint32_t> block_of_;  ///< of each child
    std::vector<std::uint32_t> stale_;     ///< blocks that are out of date
    std::vector<bool> is_stale_;
    bool is_unsorted_ = false;
    std::size_t edits_ = 0;                   ///< since the children were sorted
    double area_ = 0, area_when_sorted_ = 0;  ///< half the area of all blocks' boxes
};

}  // namespace occam
