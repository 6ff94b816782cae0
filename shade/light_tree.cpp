#include "shade/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/maths.h"
#include "shade/light_bounds.h"

namespace occam::shade {
namespace {

constexpr int kBins = 12;
// Above this number of lights a node is cut in the middle of its longest side: bins would cost more than they bring.
constexpr std::size_t kMostBinned = 16384;
// The box of a light is padded by this share of its coordinates and of its size.
constexpr float kPad = 0x1p-18f;

float luminance(Vec3f c) noexcept { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

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

LightTree::Emitter LightTree::merged(const Emitter& a, const Emitter& b) noexcept
{
    Emitter e;
    e.box = a.box;
    e.box.add(b.box);
    e.power = std::min(a.power + b.power, kMostPower);
    e.axis = unit_or(a.axis * a.power + b.axis * b.power, a.axis);
    e.cos_axis = 1;
    for (const Emitter* part : {&a, &b}) {
        const float between = std::clamp(glm::dot(e.axis, part->axis), -1.0f, 1.0f);
        e.cos_axis = std::min(e.cos_axis, cosine_of_sum(between, sine_of(between), part->cos_axis, sine_of(part->cos_axis)));
    }
    e.cos_fall = std::min(a.cos_fall, b.cos_fall);
    e.range2 = std::max(a.range2, b.range2);
    e.reach2 = std::max(a.reach2, b.reach2);
    e.groups = a.groups | b.groups;
    e.is_two_sided = a.is_two_sided || b.is_two_sided;
    return e;
}

// Measures the directions that the lights shine to (Conty Estevez and Kulla 2018, eq. 1).
float LightTree::orientation_of(const Emitter& e) noexcept
{
    const float axis = maths::acos(e.cos_axis), end = std::min(axis + maths::acos(e.cos_fall), maths::kPi);
    const float measure = 2 * maths::kPi * (1 - e.cos_axis) + maths::kPi / 2 *
                                                                  (2 * end * maths::sin(axis) - maths::cos(axis - 2 * end) -
                                                                   2 * axis * maths::sin(axis) + e.cos_axis);
    return std::max(measure, 1e-3f) * (e.is_two_sided ? 2.0f : 1.0f);
}

LightTree::LightTree(std::span<const WorldLight> lights, std::size_t first) : first_(static_cast<std::uint32_t>(first))
{
    Box3d places;
    for (const WorldLight& light : lights.subspan(first)) places.add(light.position);
    if (places.is_empty()) return;
    origin_ = places.centre();
    std::vector<Leaf> leaves;
    for (std::size_t i = first; i < lights.size(); ++i) {
        const Emitter e = emitter_of(lights[i]);
        if (e.power > 0) leaves.push_back({e, static_cast<std::uint32_t>(i)});
    }
    build(leaves, lights.size() - first);
}

void LightTree::build(std::span<Leaf> leaves, std::size_t lights)
{
    if (leaves.empty()) return;
    leaf_of_.assign(lights, kNone);
    nodes_.reserve(2 * leaves.size());
    nodes_.push_back({});
    build(0, leaves, 0);
}

// Puts the leaves of one side first, and returns how many there are.
std::size_t LightTree::split(std::span<Leaf> leaves, int depth) const
{
    Box3f middles, all;
    for (const Leaf& leaf : leaves) {
        middles.add(leaf.emitter.box.centre());
        all.add(leaf.emitter.box);
    }
    const Vec3f extent = middles.extent(), size = all.extent();
    const float longest = std::max({size.x, size.y, size.z});
    const auto bin_of = [&](const Leaf& leaf, int axis) {
        const float share = (leaf.emitter.box.centre()[axis] - middles.lo[axis]) / extent[axis];
        return std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
    };
    int best_axis = -1, best_bin = 0;
    float best = kInfinity;
    const bool is_binned = leaves.size() <= kMostBinned;
    for (int axis = 0; axis < 3 && depth < kDepth; ++axis) {
        if (!(extent[axis] > 0) || !(kBins / extent[axis] < kInfinity)) continue;
        if (!is_binned) {
            if (best_axis < 0 || extent[axis] > extent[best_axis]) best_axis = axis, best_bin = kBins / 2 - 1;
            continue;
        }
        std::array<Emitter, kBins> bins;
        std::array<std::size_t, kBins> counts{};
        for (const Leaf& leaf : leaves) {
            const auto bin = static_cast<std::size_t>(bin_of(leaf, axis));
            bins[bin] = counts[bin]++ == 0 ? leaf.emitter : merged(bins[bin], leaf.emitter);
        }
        const auto cost_of = [](const Emitter& e) { return e.power * e.box.half_area() * orientation_of(e); };
        std::array<float, kBins> above{};
        Emitter sum;
        std::size_t count = 0;
        // Adds a bin that is not empty, and returns the cost of the sum.
        const auto add = [&](std::size_t bin) {
            sum = count == 0 ? bins[bin] : merged(sum, bins[bin]);
            count += counts[bin];
            return cost_of(sum);
        };
        float cost_above = kInfinity;
        for (std::size_t bin = kBins; bin-- > 1;) {
            if (counts[bin] > 0) cost_above = add(bin);
            above[bin] = cost_above;
        }
        count = 0;
        // Long boxes are cut across.
        const float stretch = longest / std::max(size[axis], longest * 1e-6f);
        for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
            if (counts[bin] == 0) continue;  // the cut is the same as that before it
            const float cost = stretch * (add(bin) + above[bin + 1]);
            if (cost < best) best = cost, best_axis = axis, best_bin = static_cast<int>(bin);
        }
    }
    if (best_axis < 0) return leaves.size() / 2;
    const auto middle = std::stable_partition(leaves.begin(), leaves.end(),
                                              [&](const Leaf& leaf) { return bin_of(leaf, best_axis) <= best_bin; });
    return static_cast<std::size_t>(middle - leaves.begin());
}

void LightTree::build(std::uint32_t node, std::span<Leaf> leaves, int depth)
{
    if (leaves.size() == 1) {
        nodes_[node].emitter = leaves.front().emitter;
        nodes_[node].light = leaves.front().light;
        leaf_of_[leaves.front().light - first_] = node;
    } else {
        const std::size_t count = split(leaves, depth);
        const auto left = static_cast<std::uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + 2);
        nodes_[node].left = left;
        nodes_[left].parent = nodes_[left + 1].parent = node;
        build(left, leaves.first(count), depth + 1);
        build(left + 1, leaves.subspan(count), depth + 1);
        nodes_[node].emitter = merged(nodes_[left].emitter, nodes_[left + 1].emitter);
    }
    Node& made = nodes_[node];
    made.centre = made.emitter.box.centre();
    made.radius2 = glm::dot(made.emitter.box.hi - made.centre, made.emitter.box.hi - made.centre);
    made.sin_axis = sine_of(made.emitter.cos_axis);
}

}  // namespace occam::shade
