#include "accel/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/power_of_two.h"
#include "base/stopwatch.h"

namespace occam::accel {
namespace {

constexpr std::size_t kEnough = 16;   // candidates to choose a plane from; 8 and 24 are slower (docs/what-was-tried.md)
constexpr std::size_t kMany = 64;     // candidates above which planes are tried at fixed steps
constexpr float kTraversalCost = 64;  // in the units of Item::cost; 32 is slower (docs/what-was-tried.md)
constexpr float kEmptyBonus = 0.8f;   // factor of the cost of a split that cuts off empty space
constexpr float kLeastCut = 0.25f;    // the share of a side that is cut off with the bonus; thin slices cost depth
constexpr int kSteps = 32;

}  // namespace

/// Measures a box by a unit near its longest side, a power of two. Areas then neither overflow nor underflow, and a plane
/// can be found in every box whose sides are finite.
class KdTree::BoxMeasure {
public:
    explicit BoxMeasure(const Box3f& box) noexcept : extent(box.extent())
    {
        const float longest = std::max({extent.x, extent.y, extent.z});
        if (!(longest >= 0x1p-120f && longest <= 0x1p120f)) return;
        unit_ = static_cast<float>(power_of_two_double(-std::ilogb(longest)));
        const Vec3f e = extent * unit_;
        area = e.x * e.y + e.y * e.z + e.z * e.x;
        for (int axis = 0; axis < 3; ++axis) {
            const float e1 = e[(axis + 1) % 3], e2 = e[(axis + 2) % 3];
            cap_[axis] = e1 * e2;
            girth_[axis] = (e1 + e2) * unit_;
        }
    }

    Vec3f extent;
    float area = 0;  ///< half the surface; 0 if the box cannot be measured
    /// Returns half the surface of a part of the box that is `length` long along the axis.
    template <class F>
    F area_of(int axis, F length) const noexcept
    {
        return F(cap_[axis]) + F(girth_[axis]) * length;
    }

private:
    float unit_ = 0, cap_[3]{}, girth_[3]{};
};

KdTree::KdTree(Items& items, Arena& arena, TraceCounters& counters, bool may_scan, Building* building)
    : arena_(arena),
      counters_(counters),
      may_scan_(may_scan),
      building_(building),
      nodes_(arena),
      heads_(arena),
      records_(arena),
      leaves_(arena),
      candidates_(items)
{
}

void KdTree::restart(const Box3f& bounds, std::span<const ItemIndex> roots)
{
    nodes_.clear();
    heads_.clear();
    records_.clear();
    leaves_.clear();
    const std::span<ItemIndex> list = arena_.make_array<ItemIndex>(roots.size());
    std::copy(roots.begin(), roots.end(), list.begin());
    records_.push_back({bounds, list, 0});
    leaves_.push_back({});
    leaves_.push_back({});
    nodes_.push_back({0, KdLink::to_leaf(1).bits});
}

void KdTree::expand_all(int pair)
{
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
        while (!nodes_[n].link().is_interior() && !leaf(n, pair)) {
        }
}

KdTree::Split KdTree::scanned_split(const Box3f& box) const
{
    Split best;
    const BoxMeasure measure(box);
    const Vec3f extent = measure.extent;
    const float area = measure.area;
    float all = 0;
    for (const Candidate& c : candidates_) all += c.cost;
    best.cost = all;  // the cost without a split
    if (!(area > 0)) return best;
    for (int axis = 0; axis < 3; ++axis) {
        // These are the costs of the boxes that begin, and that end, between two planes.
        float begins[kSteps + 1] = {}, ends[kSteps + 1] = {};
        const float per_length = float(kSteps) / extent[axis];
        if (!(per_length < std::numeric_limits<float>::max())) continue;
        const auto step = [&](float x) { return std::clamp(static_cast<int>((x - box.lo[axis]) * per_length), 0, kSteps); };
        for (const Candidate& c : candidates_) {
            begins[step(c.box.lo[axis])] += c.cost;
            ends[step(c.box.hi[axis])] += c.cost;
        }
        float below = 0, ended = 0;
        for (int plane = 1; plane < kSteps; ++plane) {
            below += begins[plane - 1];
            ended += ends[plane - 1];
            const float above = all - ended, share = float(plane) / float(kSteps) * extent[axis];
            const float position = box.lo[axis] + share;
            if (!(position > box.lo[axis] && position < box.hi[axis])) continue;
            float cost = kTraversalCost +
                         (measure.area_of(axis, share) * below + measure.area_of(axis, extent[axis] - share) * above) / area;
            const float cut = below == 0 ? share : extent[axis] - share;
            if ((below == 0 || !(above > 0)) && cut >= kLeastCut * extent[axis]) cost *= kEmptyBonus;
            if (cost < best.cost) best = {axis, position, cost};
        }
    }
    return best;
}

template <int kVectors>
std::size_t KdTree::try_planes(const Box3f& box, const BoxMeasure& measure, int axis, std::size_t first, Split& best) const
{
    // Each candidate is read once for all these planes.
    vfloat position[kVectors], below[kVectors], above[kVectors];
    for (int v = 0; v < kVectors; ++v) {
        position[v] = vfloat::load(&planes_[first + static_cast<std::size_t>(v) * kLanes]);
        below[v] = above[v] = 0.0f;
    }
    for (const Candidate& c : candidates_) {
        const vfloat low = c.box.lo[axis], high = c.box.hi[axis], cost = c.cost;
        for (int v = 0; v < kVectors; ++v) {
            below[v] = below[v] + select(low < position[v], cost, vfloat(0.0f));
            above[v] = above[v] + select(high > position[v], cost, vfloat(0.0f));
        }
    }
    const vfloat least = kLeastCut * measure.extent[axis];
    for (int v = 0; v < kVectors; ++v) {
        const vfloat length_below = position[v] - vfloat(box.lo[axis]), length_above = vfloat(box.hi[axis]) - position[v];
        const vfloat sum = measure.area_of(axis, length_below) * below[v] + measure.area_of(axis, length_above) * above[v];
        vfloat cost = kTraversalCost + sum / measure.area;
        const vmask cuts = ((below[v] == 0.0f) & (length_below >= least)) | ((above[v] == 0.0f) & (length_above >= least));
        cost = select(cuts, cost * kEmptyBonus, cost);
        if (none(cost < best.cost)) continue;
        float costs[kLanes];
        cost.store(costs);
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            if (costs[lane] < best.cost)
                best = {axis, planes_[first + static_cast<std::size_t>(v) * kLanes + lane], costs[lane]};
    }
    return std::size_t(kVectors) * kLanes;
}

KdTree::Split KdTree::counted_split(const Box3f& box)
{
    Split best;
    const BoxMeasure measure(box);
    for (const Candidate& c : candidates_) best.cost += c.cost;  // the cost without a split
    // No split costs less than passing its plane.
    if (!(measure.area > 0) || best.cost <= kTraversalCost * kEmptyBonus) return best;
    for (int axis = 0; axis < 3; ++axis) {
        planes_.clear();
        for (const Candidate& c : candidates_)
            for (const float position : {c.box.lo[axis], c.box.hi[axis]})
                if (position > box.lo[axis] && position < box.hi[axis]) planes_.push_back(position);
        if (planes_.empty()) continue;
        planes_.resize((planes_.size() + kLanes - 1) / kLanes * kLanes, planes_.back());
        for (std::size_t p = 0; p < planes_.size();) {
            const std::size_t vectors = (planes_.size() - p) / kLanes;
            p += vectors >= 4   ? try_planes<4>(box, measure, axis, p, best)
                 : vectors >= 2 ? try_planes<2>(box, measure, axis, p, best)
                                : try_planes<1>(box, measure, axis, p, best);
        }
    }
    return best;
}

KdTree::Split KdTree::best_split(const Box3f& box)
{
    if (candidates_.size() <= kMany) return counted_split(box);
    if (may_scan_)
        if (const Split scanned = scanned_split(box); scanned.axis >= 0) return scanned;
    return swept_split(box);
}

KdTree::Split KdTree::swept_split(const Box3f& box)
{
    float all = 0;
    for (const Candidate& c : candidates_) all += c.cost;
    Split best;
    best.cost = all;  // the cost without a split
    const BoxMeasure measure(box);
    const float area = measure.area;
    if (!(area > 0)) return best;

    std::vector<Event>& low = low_events_;
    std::vector<Event>& high = high_events_;
    for (int axis = 0; axis < 3; ++axis) {
        low.clear();
        high.clear();
        for (const Candidate& c : candidates_) {
            low.push_back({c.box.lo[axis], c.cost});
            high.push_back({c.box.hi[axis], c.cost});
        }
        const auto before = [](const Event& a, const Event& b) { return a.position < b.position; };
        std::sort(low.begin(), low.end(), before);
        std::sort(high.begin(), high.end(), before);
        // The cost below a plane is that of all boxes that begin before it; above, of all that do not end before it.
        float below = 0, ended = 0;
        std::size_t l = 0, h = 0;
        const auto consider = [&](float position) {
            if (!(position > box.lo[axis] && position < box.hi[axis])) return;
            while (l < low.size() && low[l].position < position) below += low[l++].cost;
            while (h < high.size() && high[h].position <= position) ended += high[h++].cost;
            const float above = all - ended;
            const float area_below = measure.area_of(axis, position - box.lo[axis]),
                        area_above = measure.area_of(axis, box.hi[axis] - position);
            float cost = kTraversalCost + (area_below * below + area_above * above) / area;
            const float cut = below == 0 ? position - box.lo[axis] : box.hi[axis] - position;
            if ((below == 0 || h == high.size()) && cut >= kLeastCut * measure.extent[axis]) cost *= kEmptyBonus;
            if (cost < best.cost) best = {axis, position, cost};
        };
        // Considers the planes at the faces of boxes in rising order.
        for (std::size_t i = 0, j = 0; i < low.size() || j < high.size();) {
            if (j == high.size() || (i < low.size() && low[i].position <= high[j].position)) consider(low[i++].position);
            else consider(high[j++].position);
        }
    }
    return best;
}

void KdTree::make_lazy(const Box3f& box, int depth, int axis, float position, bool upper)
{
    const auto is_in = [&](const Candidate& c) {
        return upper ? c.box.hi[axis] > position : c.box.lo[axis] < position || c.box.hi[axis] <= position;
    };
    std::size_t count = 0;
    for (const Candidate& c : candidates_) count += is_in(c);
    const std::span<ItemIndex> list = arena_.make_array<ItemIndex>(count);
    std::size_t n = 0;
    for (const Candidate& c : candidates_)
        if (is_in(c)) list[n++] = c.item;
    Box3f half = box;
    (upper ? half.lo : half.hi)[axis] = position;
    const auto leaf = static_cast<std::uint32_t>(leaves_.size());
    KdLeaf unknown;
    unknown.record = static_cast<std::uint32_t>(records_.size());
    leaves_.push_back(unknown);
    records_.push_back({half, list, depth});
    nodes_.push_back({0, KdLink::to_leaf(leaf).bits});
}

KdLeaf* KdTree::make_leaf(std::uint32_t n, std::uint32_t head, std::uint32_t record)
{
    KdLeaf leaf{candidates_.leaf(arena_), head, record};
    const auto at = static_cast<std::uint32_t>(leaves_.size());
    // The first leaf of a node, which holds only its record, need not stay in the list.
    if (leaf.next != 0 && leaves_[leaf.next].entries.empty() && leaves_[leaf.next].pairs.is_empty()) leaf.next = 0;
    KdLeaf& made = leaves_.push_back(leaf);
    const KdLink link = nodes_[n].link();
    if (link.is_interior()) publish(heads_[link.first_child() >> 1], at);
    else publish(nodes_[n].bits, KdLink::to_leaf(at).bits);
    return &made;
}

KdLeaf* KdTree::expand(std::uint32_t n, int pair)
{
    const BuildLock lock(building_);
    const KdLink link = nodes_[n].link();
    const bool was_interior = link.is_interior();
    if (building_) {
        // Another thread may have expanded the node in the meantime.
        if (was_interior && pair <= link.level()) return nullptr;
        if (KdLeaf* known = find_leaf(n, pair)) return known;
    }
    const Stopwatch watch(counters_.build_seconds);
    ++counters_.kd_expanded;
    const std::uint32_t head = head_of(n), at = leaves_[head].record;
    const Record record = records_[at];
    candidates_.start(record.box, record.items, pair);

    Split split;
    while (true) {
        if (was_interior || record.depth >= kMaxDepth || heads_.size() == KdLink::kMaxPairs) {
            while (candidates_.open_largest(Candidates::kAnyEffort)) {
            }
            split.axis = -1;
            break;
        }
        // A plane is chosen before any vertex is posed, since whatever lies beyond it may be hidden.
        while (candidates_.size() < kEnough && candidates_.open_largest(0)) {
        }
        split = best_split(record.box);
        if (split.axis >= 0) break;
        // Boxes may overlap so that no plane pays, for instance on displaced surfaces. Many items are then opened at once.
        const std::size_t wanted = candidates_.size() * 3 / 2;
        if (!candidates_.open_largest(Candidates::kAnyEffort)) break;
        while (candidates_.size() < wanted && candidates_.open_largest(Candidates::kAnyEffort)) {
        }
    }
    if (split.axis < 0) return make_leaf(n, head, at);
    const int level = std::min(candidates_.holds_to(), KdLink::kAllLevels);
    const auto children = static_cast<std::uint32_t>(heads_.size());
    make_lazy(record.box, record.depth + 1, split.axis, split.position, false);
    make_lazy(record.box, record.depth + 1, split.axis, split.position, true);
    heads_.push_back(head);
    nodes_[n].split = split.position;
    publish(nodes_[n].bits, KdLink::to_children(split.axis, level, children).bits);
    counters_.kd_nodes += 2;
    return nullptr;
}

}  // namespace occam::accel
