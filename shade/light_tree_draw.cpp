// Draws lights from a tree: its estimates for a receiver, and the parts into which it is divided for one.
#include <algorithm>
#include <cmath>

#include "shade/light_bounds.h"
#include "shade/light_tree.h"

namespace occam::shade {
namespace {

// The largest float below 1.
constexpr double kBelowOne = 1 - 0x1p-24;

}  // namespace

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

// A subtree of those into which the tree is divided for a receiver.
struct LightTree::Part {
    std::uint32_t node;
    float importance;
    float doubt;  // the importance times what it may be wrong by; 0 for a single light
};

class LightTree::Parts {
public:
    /// draws   lights that are drawn at most; there are up to twice as many parts, unless one light is drawn from all
    explicit Parts(int draws) noexcept
        : draws_(std::clamp(draws, 1, kMostDraws)), most_(draws_ == 1 ? 1 : 2 * draws_), weak_(0.5f / float(draws_))
    {
    }

    std::span<const Part> all() const noexcept { return {parts_.data(), std::size_t(count_)}; }
    void add(const Part& part) noexcept
    {
        if (part.importance > 0) parts_[std::size_t(count_++)] = part;
    }
    void remove(int i) noexcept { parts_[std::size_t(i)] = parts_[std::size_t(--count_)]; }
    // Returns the index of the part that is to be divided next, or -1 if there are enough or nothing in doubt is left that
    // matters.
    int next_to_divide() noexcept
    {
        if (count_ == most_) return -1;
        sum_up();
        int next = -1;
        float least = sum_ * weak_;
        for (int i = 0; i < count_; ++i)
            if (parts_[std::size_t(i)].doubt > least) least = parts_[std::size_t(next = i)].doubt;
        return next;
    }
    // Decides the chances, once all is divided: they are as large as the number of draws allows.
    void finish() noexcept
    {
        constexpr float kFirst = 1.0f / 16;
        sum_up();
        const float last = 1 / float(draws_);  // with it no more are to be expected than there are draws
        for (weak_ = last * kFirst; weak_ < last; weak_ *= 2) {
            float expected = 0;
            for (const Part& part : all()) expected += chance(part);
            if (expected <= float(draws_)) return;
        }
        weak_ = last;
    }
    // Returns the chance with which a light is drawn from a part: 1 unless less than a certain share of the light comes from
    // it.
    float chance(const Part& part) const noexcept { return std::min(part.importance / (sum_ * weak_), 1.0f); }

private:
    void sum_up() noexcept
    {
        sum_ = 0;
        for (const Part& part : all()) sum_ += part.importance;
    }

    int draws_, most_, count_ = 0;
    float weak_;  // a part with a smaller share of all light is not divided, and at last drawn from by chance
    float sum_ = 0;
    std::array<Part, 2 * kMostDraws> parts_{};
};

LightTree::Part LightTree::part_of(const Node& node, std::uint32_t index, const Receiver& receiver) noexcept
{
    constexpr float kMostWrong = 2;
    const float estimate = importance(node, receiver);
    if (node.left == 0 || !(estimate > 0)) return {index, estimate, 0};
    // All power may lie where the ball around the lights is nearest.
    const Vec3f to = node.centre - receiver.point;
    const float distance = std::sqrt(glm::dot(to, to)), gap = distance - std::sqrt(node.radius2);
    const float nearer = gap > 0 ? distance / gap : kInfinity;
    return {index, estimate, estimate * std::min(nearer * nearer, kMostWrong)};
}

LightTree::Parts LightTree::divide(const Receiver& receiver, int most) const noexcept
{
    Parts parts(most);
    // Where the whole tree is the only part, nobody asks for its estimate.
    parts.add({0, 1, nodes_[0].left == 0 ? 0.0f : 1.0f});
    for (int next = parts.next_to_divide(); next >= 0; next = parts.next_to_divide()) {
        const std::uint32_t left = nodes_[parts.all()[std::size_t(next)].node].left;
        parts.remove(next);
        parts.add(part_of(nodes_[left], left, receiver));
        parts.add(part_of(nodes_[left + 1], left + 1, receiver));
    }
    parts.finish();
    return parts;
}

bool LightTree::draw_below(std::uint32_t at, const Receiver& receiver, double number, Pick& pick) const noexcept
{
    double low = 0, high = 1;
    float probability = 1;
    while (nodes_[at].left != 0) {
        const std::uint32_t first = nodes_[at].left;
        const float left = importance(nodes_[first], receiver), right = importance(nodes_[first + 1], receiver);
        const float both = left + right;
        if (!(both > 0)) return false;
        const double middle = low + (high - low) * double(left / both);
        const bool is_left = left > 0 && (!(right > 0) || number < middle);
        (is_left ? high : low) = middle;
        probability *= (is_left ? left : right) / both;
        at = is_left ? first : first + 1;
    }
    const double share = high > low ? (number - low) / (high - low) : 0.5;
    pick = {nodes_[at].light, probability, static_cast<float>(std::clamp(share, 0.0, kBelowOne))};
    return true;
}

int LightTree::draw(const Receiver& receiver, float number, std::span<Pick> picks) const noexcept
{
    if (nodes_.empty()) return 0;
    constexpr double kGoldenRatio = 0.6180339887498949;
    const Parts parts = divide(receiver, static_cast<int>(picks.size()));
    int count = 0;
    // A part is drawn from where the sum of the number and of the chances so far passes a whole number. By how much is a
    // number for the choice within the part; those of neighbouring parts are moved apart.
    double sum = double(number), apart = 0;
    for (const Part& part : parts.all()) {
        const float chance = parts.chance(part);
        sum += double(chance);
        // Rounding of the chances may not give more picks than there is room for.
        if (sum >= 1 && std::size_t(count) < picks.size()) {
            sum -= 1;
            const double within = std::min(sum / double(chance), kBelowOne) + apart;
            Pick& pick = picks[std::size_t(count)];
            if (draw_below(part.node, receiver, within < 1 ? within : within - 1, pick)) {
                pick.expected *= chance;
                ++count;
            }
        }
        apart += kGoldenRatio;
        if (apart >= 1) apart -= 1;
    }
    return count;
}

float LightTree::expected(std::uint32_t light, const Receiver& receiver, int draws) const noexcept
{
    std::uint32_t at = leaf_of_[light - first_];
    if (at == kNone) return 0;
    const Parts parts = divide(receiver, draws);
    float product = 1;
    while (true) {
        for (const Part& part : parts.all())
            if (part.node == at) return product * parts.chance(part);
        if (at == 0) return 0;
        const std::uint32_t parent = nodes_[at].parent, left = nodes_[parent].left;
        const float own = importance(nodes_[at], receiver);
        if (!(own > 0)) return 0;
        product *= own / (own + importance(nodes_[at == left ? left + 1 : left], receiver));
        at = parent;
    }
}

}  // namespace occam::shade
