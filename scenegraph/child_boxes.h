// The boxes of a node's many children in a tree, so that an edit of one child visits few of the others.
//
// This is a complete binary tree over blocks of kBlock children, in their order: an edit costs its block and one box for
// each level above it. It does not matter where the children lie in space, since only the union of all boxes is queried.
//
// Space    the axes of the boxes that are given: the parent's own.
// Memory   6 to 12 bytes a child.
// Threads  as Scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/box.h"

namespace occam {

class ChildBoxes {
public:
    static constexpr std::size_t kBlock = 16;

    /// Marks the child's box as out of date.
    void touch(std::size_t child)
    {
        if (child / kBlock < leaves_) touch_block(static_cast<std::uint32_t>(child / kBlock));
    }
    /// Makes room for this many children; call it first. If the capacity grows, all boxes are out of date.
    void resize(std::size_t children);

    /// Calls visit(i) for every child that refit() will visit.
    template <class Visit>
    void for_each_stale(Visit&& visit) const
    {
        for (const std::uint32_t block : stale_)
            for (std::size_t i = block * kBlock; i < std::min(children_, (block + 1) * kBlock); ++i) visit(i);
    }
    /// Updates the tree and returns the number of boxes it visited. box_of(i) returns a child's box, empty if it shows
    /// nothing.
    template <class BoxOf>
    std::size_t refit(BoxOf&& box_of)
    {
        for (const std::uint32_t block : stale_) boxes_[leaves_ + block] = Box3d();
        std::size_t looked_at = 0;
        for_each_stale([&](std::size_t i) {
            boxes_[leaves_ + i / kBlock].add(box_of(i));
            ++looked_at;
        });
        return looked_at + refit_above();
    }
    const Box3d& bounds() const noexcept { return boxes_[1]; }

private:
    void touch_block(std::uint32_t block)
    {
        if (is_stale_[block]) return;
        is_stale_[block] = true;
        stale_.push_back(block);
    }
    std::size_t refit_above();

    std::size_t children_ = 0;
    std::size_t leaves_ = 0;    ///< capacity in blocks: a power of two
    std::vector<Box3d> boxes_;  ///< the root is 1, the children of n are 2n and 2n + 1, and the blocks start at leaves_
    std::vector<std::uint32_t> stale_;  ///< blocks whose boxes are out of date
    std::vector<bool> is_stale_;
};

}  // namespace occam
