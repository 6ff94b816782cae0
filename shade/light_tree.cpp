#include "shade/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/maths.h"

namespace occam::shade {
namespace {

constexpr int kBins = 12;
// Above this number of lights a node is cut in the middle of its longest side: bins would cost more than they bring.
constexpr std::size_t kMostBinned = 16384;
// Sums and quotients of powers within these bounds are finite and not zero.
constexpr float kLeastPower = 1e-30f, kMostPower = 1e30f;
constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Bounds of cosines are floats: below minus this a light counts as turned away, and no factor is smaller than this.
constexpr float kMargin = 0.01f;
// The largest float below 1.
constexpr double kBelowOne = 1 - 0x1p-24;
// The box of a light is padded by this share of its coordinates and of its size.
constexpr float kPad = 0x1p-18f;

float luminance(Vec3f c) noexcept { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

float sine_of(float cosine) noexcept { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); }

// Returns the cosine of a sum of two angles in [0, pi], or -1 if the sum is larger than pi.
float cosine_of_sum(float cos_a, float sin_a, float cos_b, float sin_b) noexcept
{
    return cos_a <= -cos_b ? -1 : cos_a * cos_b - sin_a * sin_b;
}

// Returns the cosine of a - b, or 1 if b is the larger of the two angles.
float cosine_of_rest(float cos_a, float sin_a, float cos_b, float sin_b) noexcept
{
    return cos_a >= cos_b ? 1 : cos_a * cos_b + sin_a * sin_b;
}

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
        const auto add = [&](std::size_t bin) {
            if (counts[bin] == 0) return;
            sum = count == 0 ? bins[bin] : merged(sum, bins[bin]);
            count += counts[bin];
        };
        for (std::size_t bin = kBins; bin-- > 1;) {
            add(bin);
            above[bin] = count > 0 ? cost_of(sum) : kInfinity;
        }
        count = 0;
        // Long boxes are cut across.
        const float stretch = longest / std::max(size[axis], longest * 1e-6f);
        for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
            add(bin);
            if (count == 0) continue;
            const float cost = stretch * (cost_of(sum) + above[bin + 1]);
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

float LightTree::importance(const Node& node, const Receiver& receiver) noexcept
{
    const Emitter& e = node.emitter;
    if ((e.groups & receiver.groups) == 0) return 0;
    if (e.range2 < kInfinity) {
        const Vec3f off = glm::max(glm::max(e.box.lo - receiver.point, receiver.point - e.box.hi), Vec3f(0));
        if (glm::dot(off, off) > e.range2) return 0;
    }
    const Vec3f to = node.centre - receiver.point;
    const float distance2 = glm::dot(to, to), least2 = std::max(node.radius2, kMinDistance2);
    // Within the ball around the lights nothing is known of directions.
    if (distance2 <= least2) return std::clamp(e.power / least2, kLeastPower, kMostPower);
    const float inverse = 1 / std::sqrt(distance2);
    const float sin_ball2 = std::min(node.radius2 / distance2, 1.0f), sin_ball = std::sqrt(sin_ball2),
                cos_ball = std::sqrt(1 - sin_ball2);
    const auto clamped = [](float cosine) { return std::clamp(cosine, -1.0f, 1.0f); };

    float facing = clamped(glm::dot(to, receiver.normal) * inverse);
    if (receiver.is_two_sided) facing = std::fabs(facing);
    facing = cosine_of_rest(facing, sine_of(facing), cos_ball, sin_ball);
    if (facing < -kMargin) return 0;

    float turned = clamped(-glm::dot(to, e.axis) * inverse);
    if (e.is_two_sided) turned = std::fabs(turned);
    const float cos_spread = cosine_of_sum(e.cos_axis, node.sin_axis, cos_ball, sin_ball);
    turned = cosine_of_rest(turned, sine_of(turned), cos_spread, sine_of(cos_spread));
    if (turned < e.cos_fall - kMargin) return 0;

    const float share = std::max(facing, kMargin) * std::max(turned, kMargin);
    return std::clamp(e.power / distance2 * share, kLeastPower, kMostPower);
}

int LightTree::draw(const Receiver& receiver, float number, std::span<Pick> picks) const noexcept
{
    if (nodes_.empty()) return 0;
    const auto draws = static_cast<int>(picks.size());
    // A subtree, and the interval of [0, draws) whose numbers fall into it. The numbers are number + 0, 1, 2, ...
    struct Part {
        std::uint32_t node;
        int begin, end;
        double low, high;
        float probability;
    };
    std::array<Part, kMaxDepth> todo;
    int waiting = 0, count = 0;
    todo[waiting++] = {0, 0, draws, 0, double(draws), 1};
    while (waiting > 0) {
        const Part part = todo[--waiting];
        const Node& node = nodes_[part.node];
        if (node.left == 0) {
            for (int n = part.begin; n < part.end; ++n) {
                const double width = part.high - part.low;
                const double share = width > 0 ? (double(number) + n - part.low) / width : 0.5;
                const auto rest = static_cast<float>(std::clamp(share, 0.0, kBelowOne));
                picks[std::size_t(count++)] = {node.light, part.probability, rest};
            }
            continue;
        }
        const float left = importance(nodes_[node.left], receiver), right = importance(nodes_[node.left + 1], receiver);
        const float both = left + right;
        if (!(both > 0)) continue;
        const double middle = part.low + (part.high - part.low) * double(left / both);
        int first_right = part.begin;
        while (first_right < part.end && double(number) + first_right < middle) ++first_right;
        if (!(left > 0)) first_right = part.begin;
        if (!(right > 0)) first_right = part.end;
        if (first_right < part.end)
            todo[waiting++] = {node.left + 1, first_right, part.end, middle, part.high, part.probability * (right / both)};
        if (first_right > part.begin)
            todo[waiting++] = {node.left, part.begin, first_right, part.low, middle, part.probability * (left / both)};
    }
    return count;
}

float LightTree::probability(std::uint32_t light, const Receiver& receiver) const noexcept
{
    std::uint32_t at = leaf_of_[light - first_];
    if (at == kNone) return 0;
    float product = 1;
    while (at != 0) {
        const std::uint32_t parent = nodes_[at].parent, left = nodes_[parent].left;
        const float own = importance(nodes_[at], receiver);
        if (!(own > 0)) return 0;
        product *= own / (own + importance(nodes_[at == left ? left + 1 : left], receiver));
        at = parent;
    }
    return product;
}

}  // namespace occam::shade
