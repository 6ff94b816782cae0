#include "shade/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/luminance.h"
#include "base/maths.h"
#include "shade/light_bounds.h"

namespace occam::shade {
namespace {

constexpr int kBins = 12;
// Where there are more lights than this, the costs of cuts are computed from about as many of them.
constexpr std::size_t kMostBinned = 512;
// The box of a light is padded by this share of its coordinates and of its size.
constexpr float kPad = 0x1p-18f;
// Lights within this distance of the middle of a scene, in each axis, are near it; the scene's largest side is from 1 to 2.
constexpr double kNearScene = 64;
// The origin beside far lights is a multiple of this in each axis.
constexpr double kOriginStep = 4;

Vec3f unit_or(Vec3f v, Vec3f fallback) noexcept
{
    const float length2 = glm::dot(v, v);
    return length2 > 0 && length2 < kInfinity ? v / std::sqrt(length2) : fallback;
}

}  // namespace

LightTree::Emitter LightTree::emitter_of(const WorldLight& light) const noexcept
{
    using Kind = WorldLight::Kind;
    Emitter e;
    const Vec3f at = relative(light.position);
    Vec3f half(0);
    e.axis = light.direction;
    e.groups = light.groups;
    e.range2 = kInfinity;
    e.cos_fall = 0;
    e.power = luminance(light.strength);
    switch (light.kind) {
        case Kind::Point:
            if (light.range > 0) e.range2 = light.range * light.range * (1 + kPad);
            if (light.spot_scale > 0) e.cos_fall = std::max(0.0f, -light.spot_offset / light.spot_scale);
            // A cone wider than a hemisphere counts as a light that shines everywhere.
            if (!(light.spot_scale > 0) || light.spot_offset > 0) e.cos_axis = -1;
            break;
        case Kind::Sphere:
            half = Vec3f(light.radius);
            e.cos_axis = -1;
            e.power *= maths::kPi * light.radius * light.radius;
            e.reach2 = light.radius * light.radius;
            break;
        case Kind::Rectangle:
        case Kind::Disc:
        case Kind::Sun:
            half = glm::abs(light.half_x) + glm::abs(light.half_y);
            e.power *= light.area;
            e.is_two_sided = light.two_sided;
            // As in sine2_subtended(): no point is farther from the middle.
            e.reach2 = glm::dot(light.half_x, light.half_x) + glm::dot(light.half_y, light.half_y) +
                       2 * std::fabs(glm::dot(light.half_x, light.half_y));
            break;
    }
    if (e.power > 0) e.power = std::clamp(e.power, kLeastPower, kMostPower);
    const Vec3f pad = (glm::abs(at) + half) * kPad;
    e.box = {at - half - pad, at + half + pad};
    return e;
}

LightTree::Emitter LightTree::emitter_of(const Triangle& triangle) const noexcept
{
    Emitter e;
    float farthest = 0;
    for (const Vec3d& corner : triangle.corner) {
        const Vec3f at = relative(corner);
        e.box.add(at);
        farthest = std::max({farthest, std::fabs(at.x), std::fabs(at.y), std::fabs(at.z)});
    }
    const Vec3f pad = (Vec3f(farthest) + e.box.extent()) * kPad;
    e.box = {e.box.lo - pad, e.box.hi + pad};
    const Vec3d across = glm::cross(triangle.corner[1] - triangle.corner[0], triangle.corner[2] - triangle.corner[0]);
    e.axis = unit_or(Vec3f(across / glm::length(across)), e.axis);
    e.cos_fall = 0;
    e.range2 = kInfinity;
    e.groups = kAllGroups;
    e.is_two_sided = true;
    e.power = static_cast<float>(std::min(triangle.power, double(kMostPower)));
    if (e.power > 0) e.power = std::max(e.power, kLeastPower);
    return e;
}

LightTree::Emitter LightTree::merged(std::span<const Emitter> parts) noexcept
{
    if (parts.size() == 1) return parts.front();
    double power = 0;
    for (const Emitter& part : parts) power += double(part.power);
    Emitter e;
    e.power = static_cast<float>(std::min(power, double(kMostPower)));
    e.range2 = 0;
    Vec3f axis(0);
    for (const Emitter& part : parts) {
        e.box.add(part.box);
        e.cos_fall = std::min(e.cos_fall, part.cos_fall);
        e.range2 = std::max(e.range2, part.range2);
        e.reach2 = std::max(e.reach2, part.reach2);
        e.groups |= part.groups;
        e.is_two_sided = e.is_two_sided || part.is_two_sided;
        axis += part.axis * static_cast<float>(double(part.power) / power);
    }
    e.axis = unit_or(axis, parts.front().axis);
    for (const Emitter& part : parts) {
        const float between = std::clamp(glm::dot(e.axis, part.axis), -1.0f, 1.0f);
        e.cos_axis = std::min(e.cos_axis, cosine_of_sum(between, sine_of(between), part.cos_axis, sine_of(part.cos_axis)));
    }
    return e;
}

Vec3d LightTree::origin_for(const Box3d& places, std::optional<Vec3d> middle) noexcept
{
    if (!middle) return places.centre();
    const Vec3d farthest = glm::max(glm::abs(places.lo - *middle), glm::abs(places.hi - *middle));
    const bool are_near = std::max({farthest.x, farthest.y, farthest.z}) <= kNearScene;
    return are_near ? places.centre() : glm::round(*middle / kOriginStep) * kOriginStep;
}

LightTree::LightTree(std::span<const WorldLight> lights, std::size_t first, std::optional<Vec3d> middle)
    : first_(static_cast<std::uint32_t>(first))
{
    Box3d places;
    for (const WorldLight& light : lights.subspan(first)) places.add(light.position);
    if (places.is_empty()) return;
    origin_ = origin_for(places, middle);
    std::vector<Leaf> leaves;
    for (std::size_t i = first; i < lights.size(); ++i) {
        const Emitter e = emitter_of(lights[i]);
        if (e.power > 0) leaves.push_back({e, static_cast<std::uint32_t>(i)});
    }
    build(leaves, lights.size() - first);
}

// Makes the nodes of a tree from its leaves.
class LightTree::Builder {
public:
    Builder(LightTree& tree, std::span<const Leaf> leaves) : tree_(tree), leaves_(leaves)
    {
        double power = 0;
        for (const Leaf& leaf : leaves) power += double(leaf.emitter.power);
        items_.reserve(leaves.size());
        for (const Leaf& leaf : leaves) items_.push_back(Item(leaf.emitter, power));
        order_.resize(leaves.size());
        std::iota(order_.begin(), order_.end(), 0u);
        tree_.nodes_.emplace_back();
        make(0, {0, leaves.size(), 0, 0});
    }

private:
    // What is read of a leaf where leaves are divided.
    struct Item {
        Item(const Emitter& e, double all_power)
            : box(e.box), power(std::max(static_cast<float>(double(e.power) / all_power), kLeastPower)), cos_fall(e.cos_fall)
        {
            axis = e.axis * (power * 0.5f * (1 + e.cos_axis));
        }
        float middle(int i) const noexcept { return 0.5f * (box.lo[i] + box.hi[i]); }

        Box3f box;
        Vec3f axis;   ///< mean direction that the light shines to, times its power
        float power;  ///< share of the power of all
        float cos_fall;
    };
    // What the cost of a group of leaves depends on.
    struct Sum {
        Box3f box;
        Vec3f axis{0};
        float power = 0, cos_fall = 1;

        template <class T>
        void add(const T& other) noexcept
        {
            box.add(other.box);
            axis += other.axis;
            power += other.power;
            cos_fall = std::min(cos_fall, other.cos_fall);
        }
        double cost() const noexcept;
    };
    struct Range {
        std::size_t first, count;
        int depth;    ///< number of cuts that it comes from
        double cost;  ///< of its leaves
    };
    struct Cut {
        int axis = -1, bin = 0;
        double cost = std::numeric_limits<double>::infinity();
        double low = 0, high = 0;  ///< costs of the two sides
    };

    Emitter make(std::uint32_t node, const Range& all);
    std::size_t divide(const Range& all, std::array<Range, kWide>& to);
    Range cut_off(Range& range);
    Cut best_cut(std::span<const std::uint32_t> order, const Box3f& middles) const;
    void try_cuts(std::span<const std::uint32_t> order, int axis, const Box3f& middles, float stretch, Cut& best) const;
    int bin_of(std::uint32_t leaf, int axis, const Box3f& middles) const noexcept
    {
        const float share = (items_[leaf].middle(axis) - middles.lo[axis]) / (middles.hi[axis] - middles.lo[axis]);
        return std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
    }
    Box3f middles_of(std::span<const std::uint32_t> order) const noexcept
    {
        Box3f middles;
        for (const std::uint32_t leaf : order)
            middles.add(Vec3f(items_[leaf].middle(0), items_[leaf].middle(1), items_[leaf].middle(2)));
        return middles;
    }
    static void fill(Node& node, std::size_t column, const Emitter& e) noexcept;

    LightTree& tree_;
    std::span<const Leaf> leaves_;
    std::vector<Item> items_;           ///< one for each leaf
    std::vector<std::uint32_t> order_;  ///< indices of leaves; those of a node stand together
};

void LightTree::build(std::span<const Leaf> leaves, std::size_t lights)
{
    if (leaves.empty()) return;
    place_of_.assign(lights, kNowhere);
    Builder(*this, leaves);
}

// Multiplies power, squared size and a measure of the directions that the lights shine to (Conty Estevez and Kulla 2018, eq.
// 1). The measure is that of a cone about the mean direction, over which directions would be spread evenly: a parabola
// through its values at half angles of 0, 90 and 180 degrees for lights that fall to zero within 90 degrees, and less for
// narrower lights. The squared diagonal of the box replaces its area, which is zero for lights in a row.
double LightTree::Builder::Sum::cost() const noexcept
{
    const float cosine = std::min(2 * glm::length(axis) / power, 2.0f) - 1;
    const float measure = 10.93f - cosine * (4.71f + 3.07f * cosine) -
                          0.5f * maths::kPi * cos_fall * cos_fall * (1 + cosine);
    const Vec3d size(box.extent());
    return double(power) * glm::dot(size, size) * double(std::max(measure, 1e-3f));
}

void LightTree::Builder::try_cuts(std::span<const std::uint32_t> order, int axis, const Box3f& middles, float stretch,
                                  Cut& best) const
{
    std::array<Sum, kBins> bins{};
    const std::size_t step = order.size() / kMostBinned | 1;
    for (std::size_t i = 0; i < order.size(); i += step)
        bins[static_cast<std::size_t>(bin_of(order[i], axis, middles))].add(items_[order[i]]);
    std::array<double, kBins> above{};
    Sum sum;
    double cost = std::numeric_limits<double>::infinity();
    for (std::size_t bin = kBins; bin-- > 1;) {
        if (bins[bin].power > 0) {
            sum.add(bins[bin]);
            cost = sum.cost();
        }
        above[bin] = cost;
    }
    sum = {};
    for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
        if (!(bins[bin].power > 0)) continue;  // the cut is the same as that before it
        sum.add(bins[bin]);
        const double low = sum.cost(), high = above[bin + 1], both = double(stretch) * (low + high);
        if (both < best.cost) best = {axis, static_cast<int>(bin), both, low * double(step), high * double(step)};
    }
}

LightTree::Builder::Cut LightTree::Builder::best_cut(std::span<const std::uint32_t> order, const Box3f& middles) const
{
    const Vec3f extent = middles.extent();
    const float longest = std::max({extent.x, extent.y, extent.z});
    Cut best;
    for (int axis = 0; axis < 3; ++axis) {
        // Long boxes are cut across.
        if (!(extent[axis] * 8 > longest) || !(kBins / extent[axis] < kInfinity)) continue;
        try_cuts(order, axis, middles, longest / extent[axis], best);
    }
    return best;
}

// Keeps the leaves of one side of a cut in the range and returns those of the other.
LightTree::Builder::Range LightTree::Builder::cut_off(Range& range)
{
    const std::span<std::uint32_t> order = std::span(order_).subspan(range.first, range.count);
    const Box3f middles = middles_of(order);
    const Cut cut = range.depth < kDepth ? best_cut(order, middles) : Cut{};
    std::size_t kept = range.count / 2;
    if (cut.axis >= 0) {
        const auto middle = std::stable_partition(
            order.begin(), order.end(), [&](std::uint32_t leaf) { return bin_of(leaf, cut.axis, middles) <= cut.bin; });
        kept = static_cast<std::size_t>(middle - order.begin());
    }
    const Range rest{range.first + kept, range.count - kept, range.depth + 1, cut.high};
    range = {range.first, kept, range.depth + 1, cut.low};
    return rest;
}

// Divides leaves into up to as many ranges as a node has children, always that of the largest cost which is too large for
// one node. Returns how many there are.
std::size_t LightTree::Builder::divide(const Range& all, std::array<Range, kWide>& to)
{
    if (all.count <= kWide) {
        for (std::size_t i = 0; i < all.count; ++i) to[i] = {all.first + i, 1, all.depth + 1, 0};
        return all.count;
    }
    std::size_t count = 1;
    to[0] = all;
    while (count < kWide) {
        Range* next = nullptr;
        for (Range& range : std::span(to).first(count)) {
            if (range.count <= kWide) continue;
            if (!next || range.cost > next->cost || (range.cost == next->cost && range.count > next->count)) next = &range;
        }
        if (!next) break;
        to[count] = cut_off(*next);
        ++count;
    }
    return count;
}

LightTree::Emitter LightTree::Builder::make(std::uint32_t node, const Range& all)
{
    std::array<Range, kWide> ranges{};
    std::array<Emitter, kWide> emitters{};
    const std::size_t count = divide(all, ranges);
    for (std::size_t i = 0; i < count; ++i) {
        const Place place = node * std::uint32_t(kWide) + static_cast<std::uint32_t>(i);
        if (ranges[i].count == 1) {
            const Leaf& leaf = leaves_[order_[ranges[i].first]];
            emitters[i] = leaf.emitter;
            tree_.nodes_[node].below[i] = leaf.light;
            tree_.place_of_[leaf.light - tree_.first_] = place;
        } else {
            const auto child = static_cast<std::uint32_t>(tree_.nodes_.size());
            tree_.nodes_.emplace_back().place = place;
            tree_.nodes_[node].below[i] = child;
            tree_.nodes_[node].is_subtree[i] = 1;
            emitters[i] = make(child, ranges[i]);
        }
        fill(tree_.nodes_[node], i, emitters[i]);
    }
    tree_.nodes_[node].children = static_cast<std::uint32_t>(count);
    return merged(std::span(emitters).first(count));
}

void LightTree::Builder::fill(Node& node, std::size_t column, const Emitter& e) noexcept
{
    // Half a side is rounded up.
    const Vec3f middle = e.box.centre(), half = glm::max(e.box.hi - middle, middle - e.box.lo) * (1 + 0x1p-22f);
    for (int i = 0; i < 3; ++i) {
        node.middle[i][column] = middle[i];
        node.half[i][column] = half[i];
        node.axis[i][column] = e.axis[i];
    }
    node.power[column] = e.power;
    node.cos_axis[column] = e.cos_axis;
    node.sin_axis[column] = sine_of(e.cos_axis);
    node.cos_end[column] = cosine_of_sum(e.cos_axis, node.sin_axis[column], e.cos_fall, sine_of(e.cos_fall)) - kMargin;
    node.range2[column] = e.range2;
    node.reach2[column] = e.reach2;
    node.is_two_sided[column] = e.is_two_sided ? 1 : 0;
    node.groups[column] = e.groups;
    node.has_groups = node.has_groups || e.groups != kAllGroups;
}

}  // namespace occam::shade
