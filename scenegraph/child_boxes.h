// The boxes of a node's many children under a tree of boxes, so that an edit of one looks at few of the others.
//
// A complete binary tree over blocks of kBlock children in their order: an edit costs its block and one box a level above
// it. Where children lie in space does not matter, since only the union of all is asked for.
//
// Space    the axes of whoever gives the boxes: the parent's own.   Memory  6 to 12 bytes a child.   Threads  as Scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/box.h"

namespace occam {

class ChildBoxes {
public:
    static constexpr std::size_t kBlock = 16;

    /// The child's box is out of date.
    void touch(std::size_t child)
    {
        if (child / kBlock < leaves_) touch_block(static_cast<std::uint32_t>(child / kBlock));
    }
    /// Makes room for so many children, first of all. With more room than before, all are out of date.
    void resize(std::size_t children);

    /// Calls visit(i) for every child that refit() will look at.
    template <class Visit>
    void for_each_stale(Visit&& visit) const
    {
        for (const std::uint32_t block : stale_)
            for (std::size_t i = block * kBlock; i < std::min(children_, (block + 1) * kBlock); ++i) visit(i);
    }
    /// box_of(i): of a child, empty if it shows nothing. Returns how many boxes were looked at.
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
    std::size_t leaves_ = 0;            ///< blocks that there is room for: a power of two
    std::vector<Box3d> boxes_;          ///< 1 the root, 2n and 2n + 1 below n; the blocks from leaves_ on
    std::vector<std::uint32_t> stale_;  ///< blocks
    std::vector<bool> is_stale_;
};

}  // namespace occam
