#include "scenegraph/child_boxes.h"

#include <bit>
#include <numeric>

#include "base/morton.h"

namespace occam {
namespace {

double area_of(const Box3d& box) noexcept { return box.is_empty() ? 0 : box.half_area(); }

}  // namespace

void ChildBoxes::resize(std::size_t children)
{
    const std::size_t blocks = (children + kBlock - 1) / kBlock;
    const bool has_spread = edits_ >= children && area_ > 2 * area_when_sorted_;
    for (auto child = static_cast<std::uint32_t>(order_.size()); child < children; ++child) {
        block_of_.push_back(static_cast<std::uint32_t>(child / kBlock));
        order_.push_back(child);
        if (blocks <= leaves_) touch_block(block_of_.back());
    }
    if (blocks <= leaves_ && !has_spread) return;
    leaves_ = std::bit_ceil(blocks);
    sums_.assign(2 * leaves_, {});
    is_stale_.assign(leaves_, false);
    stale_.clear();
    for (std::uint32_t block = 0; block < blocks; ++block) touch_block(block);
    is_unsorted_ = true;
}

void ChildBoxes::sort(const std::vector<Box3d>& boxes)
{
    Box3d middles;
    for (const Box3d& box : boxes)
        if (!box.is_empty()) middles.add(box.centre());
    struct Place {
        std::uint64_t code;
        std::uint32_t child;
    };
    std::vector<Place> places(boxes.size());
    for (std::uint32_t child = 0; child < boxes.size(); ++child)
        places[child] = {boxes[child].is_empty() ? ~std::uint64_t(0) : morton_code(boxes[child].centre(), middles), child};
    std::sort(places.begin(), places.end(),
              [](const Place& a, const Place& b) { return a.code != b.code ? a.code < b.code : a.child < b.child; });
    for (std::size_t i = 0; i < places.size(); ++i) {
        order_[i] = places[i].child;
        block_of_[places[i].child] = static_cast<std::uint32_t>(i / kBlock);
    }
    is_unsorted_ = false;
    edits_ = 0;
    area_ = area_when_sorted_ = 0;
}

void ChildBoxes::store_block(std::uint32_t block, const Sum& sum) noexcept
{
    Sum& known = sums_[leaves_ + block];
    area_ += area_of(sum.box) - area_of(known.box);
    known = sum;
}

// Goes up level by level, so that a box above several changed ones is made only once.
std::size_t ChildBoxes::refit_above()
{
    if (edits_ == 0) area_when_sorted_ = area_;
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
            sums_[node] = sums_[2 * node];
            sums_[node].add(sums_[2 * node + 1]);
            level[parents++] = parent;
        }
        level.resize(parents);
        looked_at += 2 * parents;
    }
    return looked_at;
}

std::size_t ChildBoxes::most_at_once(std::size_t children) noexcept
{
    // Two nodes a level, down to one block.
    return children <= kMostAtOnce ? children : kBlock + 2 * std::size_t(std::bit_width(children / kBlock) + 1);
}

void ChildBoxes::find(Contents::Kinds kinds, std::vector<std::uint32_t>& out) const
{
    const std::size_t before = out.size();
    std::vector<std::uint32_t> todo{kRoot};
    while (!todo.empty()) {
        const std::uint32_t node = todo.back();
        todo.pop_back();
        if (!contents(node).has(kinds)) continue;
        if (is_block(node)) {
            const auto children_there = children(node);
            out.insert(out.end(), children_there.begin(), children_there.end());
        } else {
            todo.push_back(2 * node);
            todo.push_back(2 * node + 1);
        }
    }
    std::sort(out.begin() + std::ptrdiff_t(before), out.end());
}

}  // namespace occam
