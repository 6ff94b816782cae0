#include "accel/bvh.h"

#include <algorithm>
#include <bit>
#include <cfloat>

#include "base/stopwatch.h"

namespace occam::accel {
namespace {

constexpr std::size_t kEnough = 32;     // candidates to divide
constexpr int kBins = 16;               // bins along each axis
constexpr float kMostGrowth = 3;        // an interval in which the parts' boxes grow by more than this factor is halved
constexpr float kShortest = 1.0f / 64;  // the share of the shutter from which on intervals are not halved
constexpr Box3f kEverywhere{Vec3f(-FLT_MAX), Vec3f(FLT_MAX)};
constexpr Box3f kNothing{Vec3f(FLT_MAX), Vec3f(-FLT_MAX)};  // finite, so that it is linear between keys

// Holds the bins of candidates' middles along one axis of a part.
struct Bins {
    struct Bin {
        Box3f box;
        float cost = 0;
    };
    int axis = 0;
    float lo = 0, per_length = 0;
    Bin bins[kBins];

    int of(const Box3f& box) const noexcept
    {
        return std::clamp(static_cast<int>(((box.lo[axis] + box.hi[axis]) * 0.5f - lo) * per_length), 0, kBins - 1);
    }
};

}  // namespace

Bvh::Bvh(Items& items, Arena& arena, TraceCounters& counters, int segments, Building* building)
    : items_(items), arena_(arena), counters_(counters), segments_(segments), building_(building), candidates_(items)
{
}

void Bvh::restart(std::span<const ItemIndex> roots)
{
    const std::span<ItemIndex> list = arena_.make_array<ItemIndex>(roots.size());
    std::copy(roots.begin(), roots.end(), list.begin());
    root_.bits = BvhState::of(*make_lazy({list, 0}));
}

void Bvh::expand_all(int pair)
{
    std::vector<BvhLink*> todo{&root_};
    while (!todo.empty()) {
        BvhLink* at = todo.back();
        todo.pop_back();
        if (!at->state().is_interior() && leaf(at, pair)) continue;
        BvhNode& node = at->state().node();
        for (int i = 0; i < node.count; ++i) todo.push_back(&node.children[i]);
    }
}

BvhLeaf* Bvh::expand(BvhLink* at, int pair)
{
    const BuildLock lock(building_);
    const BvhState state = at->state();
    const bool was_interior = state.is_interior();
    if (building_) {
        // Another thread may have expanded it meanwhile.
        if (was_interior && pair <= state.node().level) return nullptr;
        if (BvhLeaf* known = find_leaf(state, pair)) return known;
    }
    const Stopwatch watch(counters_.build_seconds);
    ++counters_.kd_expanded;
    BvhLeaf* first = first_leaf(state);
    const BvhRecord* record = first->record;
    const float middle = 0.5f * (record->begin + record->end);
    candidates_.start(kEverywhere, record->items, pair, segments_ > 0 ? middle : Candidates::kAllTimes);
    if (was_interior || record->depth >= kMaxDepth) {
        while (candidates_.open_largest(Candidates::kAnyEffort)) {
        }
        return make_leaf(at, state, record);
    }
    open_enough();
    if (is_leaf()) return make_leaf(at, state, record);
    divide();
    if (segments_ > 0 && grows(*record)) make_halved_node(at, first, *record);
    else make_node(at, first, *record);
    return nullptr;
}

void Bvh::open_enough()
{
    const auto open_free = [&] {
        while (candidates_.size() < kEnough && candidates_.open_largest(0)) {
        }
    };
    // The candidates are divided before a vertex is looked at, because what lies in another part may be hidden.
    open_free();
    while (candidates_.size() == 1 && candidates_.open_largest(Candidates::kAnyEffort)) open_free();
    const bool are_regions = std::all_of(candidates_.begin(), candidates_.end(), [&](const Candidate& c) {
        return c.is_final || items_.effort(c.item) == Candidates::kAnyEffort;
    });
    while (are_regions && candidates_.size() < BvhNode::kWidth && candidates_.open_largest(Candidates::kAnyEffort)) {
    }
}

bool Bvh::is_leaf() const noexcept
{
    return candidates_.size() <= kBoxGroup &&
           std::all_of(candidates_.begin(), candidates_.end(), [](const Candidate& c) { return c.is_final; });
}

KeySpan Bvh::keys_of(const BvhRecord& record) const noexcept
{
    if (segments_ == 0 || !candidates_.move()) return {};
    const float length = record.end - record.begin;
    const int segments = std::max(1, static_cast<int>(length * static_cast<float>(segments_)));
    return {segments, record.begin, static_cast<float>(segments) / length};
}

void Bvh::set_boxes(float* boxes, std::size_t stride, std::size_t place, const KeySpan& keys, std::size_t begin,
                    std::size_t end) const
{
    const auto at = [&](int key) {
        Box3f box;
        for (std::size_t c = begin; c < end; ++c)
            box.add(candidates_.box_at(candidates_[c].item, keys.begin + static_cast<float>(key) / keys.per_time));
        return box;
    };
    // The boxes are rounded twice, at keys that are not the items' own and at the time of a ray.
    GrowthAtKeys growth;
    for (int key = 0; key <= keys.segments; ++key) {
        const Box3f box = at(key);
        const Vec3f pad(growth.next(box));
        set_box(boxes + static_cast<std::size_t>(key) * stride, place, {box.lo - pad, box.hi + pad}, keys.row);
    }
}

BvhLeaf* Bvh::make_leaf(BvhLink* at, BvhState state, const BvhRecord* record)
{
    KeySpan keys = keys_of(*record);
    // Most leaves have one or two boxes, and each has one at every key.
    if (keys.segments > 0 && candidates_.size() < kBoxGroup)
        keys.row = static_cast<int>(std::bit_ceil(std::max<std::size_t>(1, candidates_.size())));
    TreeLeaf leaf = candidates_.leaf(arena_, keys);
    if (keys.segments > 0) {
        for (std::size_t c = 0; c < candidates_.size(); ++c) set_boxes(leaf.boxes, leaf.stride(), c, keys, c, c + 1);
        const auto row = static_cast<std::size_t>(keys.row);
        for (int key = 0; key <= keys.segments; ++key)
            for (std::size_t c = candidates_.size(); c % row != 0; ++c)
                set_box(leaf.boxes + static_cast<std::size_t>(key) * leaf.stride(), c, kNothing, keys.row);
    }
    BvhLeaf* first = first_leaf(state);
    // A leaf that holds for no pair has nothing but its record.
    BvhLeaf* made = arena_.make<BvhLeaf>(leaf, first->pairs.is_empty() ? first->next : first, record);
    if (state.is_interior()) publish(state.node().leaf, made);
    else publish(at->bits, BvhState::of(*made));
    return made;
}

BvhLeaf* Bvh::make_lazy(const BvhRecord& record)
{
    return arena_.make<BvhLeaf>(TreeLeaf(), nullptr, arena_.make<BvhRecord>(record));
}

BvhNode& Bvh::new_node(BvhLeaf* leaf, int keys)
{
    const std::size_t floats = static_cast<std::size_t>(keys) * kBoxGroupFloats;
    BvhNode& node = *new (arena_.make_array<std::byte>(sizeof(BvhNode) + floats * sizeof(float)).data()) BvhNode;
    node.leaf = leaf;
    return node;
}

void Bvh::make_node(BvhLink* at, BvhLeaf* leaf, const BvhRecord& record)
{
    const KeySpan keys = keys_of(record);
    BvhNode& node = new_node(leaf, keys.segments + 1);
    node.level = candidates_.holds_to();
    node.count = part_count_;
    node.keys = keys;
    float* boxes = const_cast<float*>(node.boxes());
    for (int i = 0; i < BvhNode::kWidth; ++i) {
        const auto place = static_cast<std::size_t>(i);
        if (i >= part_count_) {
            for (int key = 0; key <= keys.segments; ++key) set_box(boxes + key * kBoxGroupFloats, place, kNothing);
            continue;
        }
        const Part& part = parts_[place];
        if (keys.segments == 0) set_box(boxes, place, part.box);
        else set_boxes(boxes, kBoxGroupFloats, place, keys, part.begin, part.end);
        const std::span<ItemIndex> list = arena_.make_array<ItemIndex>(part.end - part.begin);
        for (std::size_t c = part.begin; c < part.end; ++c) list[c - part.begin] = candidates_[c].item;
        node.children[i].bits = BvhState::of(*make_lazy({list, record.depth + 1, record.begin, record.end}));
    }
    if (segments_ > 0) note_visibility(node);
    publish(at->bits, BvhState::of(node));
    counters_.kd_nodes += static_cast<std::uint64_t>(part_count_);
}

void Bvh::note_visibility(BvhNode& node)
{
    std::uint32_t seen[BvhNode::kWidth], common = lod::PosedCage::kAllSegments;
    for (int i = 0; i < part_count_; ++i) {
        const Part& part = parts_[static_cast<std::size_t>(i)];
        seen[i] = candidates_.visible_in(part.begin, part.end);
        common &= seen[i];
    }
    if (common == lod::PosedCage::kAllSegments) return;
    const std::span<std::uint32_t> kept = arena_.make_array<std::uint32_t>(BvhNode::kWidth);
    std::copy(seen, seen + part_count_, kept.begin());
    node.visible_in = kept.data();
}

void Bvh::make_halved_node(BvhLink* at, BvhLeaf* leaf, const BvhRecord& record)
{
    BvhNode& node = new_node(leaf, 0);
    node.level = Item::kNever;
    node.count = 2;
    node.halved_at = 0.5f * (record.begin + record.end);
    node.children[0].bits = BvhState::of(*make_lazy({record.items, record.depth + 1, record.begin, node.halved_at}));
    node.children[1].bits = BvhState::of(*make_lazy({record.items, record.depth + 1, node.halved_at, record.end}));
    publish(at->bits, BvhState::of(node));
    counters_.kd_nodes += 2;
}

bool Bvh::grows(const BvhRecord& record) const
{
    if (candidates_.size() <= BvhNode::kWidth || record.end - record.begin <= kShortest || !candidates_.move()) return false;
    float at_middle = 0, at_ends = 0;
    for (int i = 0; i < part_count_; ++i) {
        const Part& part = parts_[static_cast<std::size_t>(i)];
        Box3f first, last;
        float cost = 0;
        for (std::size_t c = part.begin; c < part.end; ++c) {
            first.add(candidates_.box_at(candidates_[c].item, record.begin));
            last.add(candidates_.box_at(candidates_[c].item, record.end));
            cost += candidates_[c].cost;
        }
        at_middle += cost * part.area;
        at_ends += cost * 0.5f * (first.half_area() + last.half_area());
    }
    return at_ends > kMostGrowth * at_middle;
}

void Bvh::add_part(std::size_t begin, std::size_t end)
{
    Part part{begin, end, {}, 0};
    for (std::size_t c = begin; c < end; ++c) part.box.add(candidates_[c].box);
    part.area = part.box.half_area();
    parts_[static_cast<std::size_t>(part_count_++)] = part;
}

void Bvh::divide()
{
    part_count_ = 0;
    if (candidates_.size() <= BvhNode::kWidth) {
        for (std::size_t c = 0; c < candidates_.size(); ++c) add_part(c, c + 1);
        return;
    }
    add_part(0, candidates_.size());
    while (part_count_ < BvhNode::kWidth) {
        // There are more candidates than parts, so some part has two.
        Part* largest = nullptr;
        for (int i = 0; i < part_count_; ++i) {
            Part& part = parts_[static_cast<std::size_t>(i)];
            if (part.end - part.begin > 1 && (!largest || part.area > largest->area)) largest = &part;
        }
        const Part whole = *largest;
        *largest = parts_[static_cast<std::size_t>(--part_count_)];
        const std::size_t middle = halve(whole);
        add_part(whole.begin, middle);
        add_part(middle, whole.end);
    }
}

std::size_t Bvh::halve(const Part& part)
{
    const auto first = candidates_.begin() + static_cast<std::ptrdiff_t>(part.begin),
               last = candidates_.begin() + static_cast<std::ptrdiff_t>(part.end);
    Box3f middles;
    for (auto c = first; c != last; ++c) middles.add((c->box.lo + c->box.hi) * 0.5f);
    Bins best;
    int best_plane = 0;
    float best_cost = FLT_MAX;
    for (int axis = 0; axis < 3; ++axis) {
        Bins bins;
        bins.axis = axis;
        bins.lo = middles.lo[axis];
        bins.per_length = float(kBins) / (middles.hi[axis] - middles.lo[axis]);
        if (!(bins.per_length > 0 && bins.per_length < FLT_MAX)) continue;
        for (auto c = first; c != last; ++c) {
            Bins::Bin& bin = bins.bins[bins.of(c->box)];
            bin.box.add(c->box);
            bin.cost += c->cost;
        }
        float above[kBins];
        Bins::Bin sum;
        for (int plane = kBins - 1; plane > 0; --plane) {
            sum.box.add(bins.bins[plane].box);
            sum.cost += bins.bins[plane].cost;
            above[plane] = sum.cost > 0 ? sum.box.half_area() * sum.cost : 0;
        }
        sum = {};
        for (int plane = 1; plane < kBins; ++plane) {
            sum.box.add(bins.bins[plane - 1].box);
            sum.cost += bins.bins[plane - 1].cost;
            const float cost = (sum.cost > 0 ? sum.box.half_area() * sum.cost : 0) + above[plane];
            if (!(cost < best_cost)) continue;
            best_cost = cost;
            best_plane = plane;
            best.axis = bins.axis;
            best.lo = bins.lo;
            best.per_length = bins.per_length;
        }
    }
    const auto middle = std::partition(first, last, [&](const Candidate& c) { return best.of(c.box) < best_plane; });
    // Boxes with one middle, or of infinite size, are halved by number.
    if (best_plane == 0 || middle == first || middle == last) return part.begin + (part.end - part.begin) / 2;
    return static_cast<std::size_t>(middle - candidates_.begin());
}

}  // namespace occam::accel
