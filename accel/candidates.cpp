#include "accel/candidates.h"

#include <algorithm>

#include "base/error_without_file.h"
#include "lod/key_time.h"

namespace occam::accel {

void Candidates::start(const Box3f& box, std::span<const ItemIndex> items, int pair, float time)
{
    clear();
    has_heap_ = false;
    passing_ = 0;
    left_out_to_ = Item::kNever;
    time_ = time;
    within_ = box;
    pair_ = pair;
    for (const ItemIndex item : items) add(item);
}

void Candidates::add(ItemIndex item)
{
    const Item& it = items_[item];
    const Box3f box = time_ == kAllTimes ? it.box : box_at(item, time_);
    const Box3f clipped{glm::max(box.lo, within_.lo), glm::min(box.hi, within_.hi)};
    if (clipped.is_empty()) {
        left_out_to_ = std::min<int>(left_out_to_, it.holds_to);
        return;
    }
    push_back({clipped, item, it.cost, items_.is_final(item, pair_)});
    if (passes(item)) ++passing_;
    if (has_heap_) add_to_heap(size() - 1);
}

void Candidates::make_heap()
{
    has_heap_ = true;
    heap_.clear();
    handle_at_.clear();
    place_of_.clear();
    for (std::size_t c = 0; c < size(); ++c) add_to_heap(c);
}

void Candidates::add_to_heap(std::size_t place)
{
    const auto handle = static_cast<std::uint32_t>(place_of_.size());
    handle_at_.push_back(handle);
    place_of_.push_back(static_cast<std::uint32_t>(place));
    const Candidate& candidate = (*this)[place];
    if (candidate.is_final) return;
    heap_.push_back({items_.effort(candidate.item), candidate.box.half_area(), handle});
    std::push_heap(heap_.begin(), heap_.end());
}

std::size_t Candidates::find_largest(int most_effort)
{
    if (!has_heap_ && size() >= kWorthAHeap) make_heap();
    if (has_heap_) {
        if (heap_.empty() || heap_.front().effort > most_effort) return size();
        std::pop_heap(heap_.begin(), heap_.end());
        const std::size_t place = place_of_[heap_.back().handle];
        heap_.pop_back();
        return place;
    }
    std::size_t largest = size();
    float area = -1;
    int least = most_effort;
    for (std::size_t c = 0; c < size(); ++c) {
        const Candidate& candidate = (*this)[c];
        if (candidate.is_final) continue;
        const int effort = items_.effort(candidate.item);
        if (effort > least) continue;
        if (effort < least || candidate.box.half_area() > area) {
            area = candidate.box.half_area();
            largest = c;
            least = effort;
        }
    }
    return largest;
}

bool Candidates::passes(ItemIndex item) const noexcept { return time_ == kAllTimes && !items_.key_boxes(item).empty(); }

void Candidates::remove(std::size_t place)
{
    if (passes((*this)[place].item)) --passing_;
    (*this)[place] = back();
    pop_back();
    if (!has_heap_) return;
    handle_at_[place] = handle_at_.back();
    place_of_[handle_at_[place]] = static_cast<std::uint32_t>(place);
    handle_at_.pop_back();
}

bool Candidates::open_largest(int most_effort)
{
    // Regions are opened last, because dividing them restricts the node to fine levels.
    const std::size_t largest = find_largest(most_effort);
    if (largest == size()) return false;
    const ItemIndex opened = (*this)[largest].item;
    remove(largest);
    add_parts(opened);
    return true;
}

void Candidates::add_parts(ItemIndex item)
{
    if (!items_.open(item, pair_)) return add(item);
    const std::uint32_t first = items_[item].first_part, count = items_[item].part_count;
    if (passes(item) && passing_ + count > kMostPassing)
        throw error_without_file(
            "more than " + std::to_string(kMostPassing) +
                " parts of surfaces pass through one place while the shutter is open, which the kd-tree "
                "cannot tell apart; the tree of boxes (bvh) can",
            items_.name_of(item));
    if (size() + count > kMost)
        throw error_without_file("more than " + std::to_string(kMost) +
                                     " parts of surfaces lie in one place, or too close together for their numbers",
                                 items_.name_of(item));
    for (std::uint32_t p = 0; p < count; ++p) add(first + p);
}

Box3f Candidates::box_at(ItemIndex item, float time) const noexcept
{
    const std::span<const Box3f> keys = items_.key_boxes(item);
    if (keys.empty()) return items_[item].box;
    const lod::KeyTime at = lod::key_time(time, static_cast<int>(keys.size()) - 1);
    const Box3f &a = keys[static_cast<std::size_t>(at.key)], &b = keys[static_cast<std::size_t>(at.key) + 1];
    Box3f box;
    for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = lod::between_keys(at.share, a.lo[axis], b.lo[axis]);
        box.hi[axis] = lod::between_keys(at.share, a.hi[axis], b.hi[axis]);
    }
    return box.is_empty() ? items_[item].box : box;
}

std::uint32_t Candidates::visible_in(std::size_t begin, std::size_t end) const noexcept
{
    std::uint32_t seen = 0;
    for (std::size_t c = begin; c < end; ++c) seen |= items_.visible_segments((*this)[c].item);
    return seen;
}

bool Candidates::move() const noexcept
{
    return std::any_of(begin(), end(), [&](const Candidate& c) { return !items_.key_boxes(c.item).empty(); });
}

TreeLeaf Candidates::leaf(Arena& arena, const KeySpan& keys) const
{
    // Eight floats are read from where a row begins, which may be shorter.
    const std::size_t floats = keys.stride(size()) * static_cast<std::size_t>(keys.segments + 1) + kBoxGroup -
                               static_cast<std::size_t>(keys.row);
    const std::span<float> boxes = arena.make_array<float>(floats);
    const bool move = keys.segments > 0;
    if (move) std::fill(boxes.begin(), boxes.end(), 0.0f);
    for (std::size_t c = size(); !move && c % kBoxGroup != 0; ++c) set_box(boxes.data(), c, Box3f());
    // At coarser pairs a part that was left out may reach into the node.
    const int coarsest = std::clamp(left_out_to_, pair_, lod::kCoarsestLevel);
    TreeLeaf leaf{{lod::kFinestLevel, coarsest}, arena.make_array<TreeLeaf::Entry>(size()), boxes.data(), keys};
    for (std::size_t c = 0; c < size(); ++c) {
        const ItemIndex item = (*this)[c].item;
        if (!move) set_box(boxes.data(), c, items_[item].box);
        leaf.entries[c] = {nullptr, {}, item, items_.visible_segments(item)};
        const PairRange range = items_.range(item, pair_);
        leaf.pairs = {std::max(leaf.pairs.finest, range.finest), std::min(leaf.pairs.coarsest, range.coarsest)};
    }
    return leaf;
}

int Candidates::holds_to() const noexcept
{
    int level = left_out_to_;
    for (const Candidate& c : *this) level = std::min<int>(level, items_[c.item].holds_to);
    return level;
}

}  // namespace occam::accel
