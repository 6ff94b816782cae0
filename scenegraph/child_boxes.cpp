#include "scenegraph/child_boxes.h"

#include <bit>

namespace occam {

void ChildBoxes::resize(std::size_t children)
{
    children_ = children;
    const std::size_t blocks = (children + kBlock - 1) / kBlock;
    if (blocks <= leaves_) return;
    leaves_ = std::bit_ceil(blocks);
    boxes_.assign(2 * leaves_, {});
    is_stale_.assign(leaves_, false);
    stale_.clear();
    for (std::uint32_t block = 0; block < blocks; ++block) touch_block(block);
}

// Goes up level by level, so that a box above several changed ones is made only once.
std::size_t ChildBoxes::refit_above()
{
    for (const std::uint32_t block : stale_) is_stale_[block] = false;
    std::vector<std::uint32_t> level = std::move(stale_);
    stale_.clear();
    std::sort(level.begin(), level.end());
    std::size_t looked_at = 0;
    for (std::size_t first = leaves_; first > 1; first /= 2) {
        std::size_t parents = 0;
        for (const std::uint32_t at : level) {
            const std::uint32_t parent = at / 2;
            if (parents > 0 && level[parents - 1] == parent) continue;
            const std::size_t node = first / 2 + parent;
            boxes_[node] = boxes_[2 * node];
            boxes_[node].add(boxes_[2 * node + 1]);
            level[parents++] = parent;
        }
        level.resize(parents);
        looked_at += 2 * parents;
    }
    return looked_at;
}

}  // namespace occam
