// Draws lights from a tree: its estimates for a receiver, and the parts into which it is divided for one. Finds lights by a
// ray or a point.
#include <algorithm>
#include <cmath>

#include "base/simd.h"
#include "shade/light_bounds.h"
#include "shade/light_tree.h"

namespace occam::shade {
namespace {

// The largest float below 1.
constexpr double kBelowOne = 1 - 0x1p-24;
// A child's estimate is zero only if all of it lies farther below the surface than this share of its distance.
constexpr float kBelowSurface = 0x1p-10f;

// Vectors side by side.
struct Lanes3 {
    vfloat x, y, z;

    static Lanes3 load(const float (&rows)[3][8], std::size_t column) noexcept
    {
        return {vfloat::load(rows[0] + column), vfloat::load(rows[1] + column), vfloat::load(rows[2] + column)};
    }
    friend Lanes3 operator-(const Lanes3& a, Vec3f b) noexcept
    {
        return {a.x - vfloat(b.x), a.y - vfloat(b.y), a.z - vfloat(b.z)};
    }
    friend Lanes3 operator+(const Lanes3& a, const Lanes3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Lanes3 operator-(const Lanes3& a, const Lanes3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Lanes3 abs(const Lanes3& a) noexcept { return {abs(a.x), abs(a.y), abs(a.z)}; }
    friend vfloat dot(const Lanes3& a, const Lanes3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
    /// Returns the parts that are above zero.
    Lanes3 positive() const noexcept { return {max(x, vfloat(0.0f)), max(y, vfloat(0.0f)), max(z, vfloat(0.0f))}; }
};

Lanes3 in_all_lanes(Vec3f v) noexcept { return {vfloat(v.x), vfloat(v.y), vfloat(v.z)}; }

vfloat clamped(vfloat x, float least, float most) noexcept { return min(max(x, vfloat(least)), vfloat(most)); }
vfloat sine_of(vfloat cosine) noexcept { return sqrt(max(vfloat(1.0f) - cosine * cosine, vfloat(0.0f))); }

// Returns about the mean of what is above zero, for numbers that are spread evenly over [middle - half, middle + half], if
// any are.
vfloat mean_above_zero(vfloat middle, vfloat half) noexcept { return max(middle, (middle + half) * vfloat(0.5f)); }

// Adds eight numbers in an order that does not depend on the number of lanes.
float sum_of(const float (&row)[8]) noexcept
{
    return ((row[0] + row[4]) + (row[2] + row[6])) + ((row[1] + row[5]) + (row[3] + row[7]));
}

}  // namespace

float LightTree::Estimates::sum() const noexcept { return sum_of(light); }

// The light of a child is estimated as if all of it stood at the middle of its box, but with the mean of the cosines that
// the places of the box have: a plane of lamps then has its small share on a floor below it, also where its box is wide. An
// estimate is never less than a small part of what power and distance alone would give. It is zero where bounds show
// that nothing arrives: the whole box is below the surface, too far away, or does not shine this way.
void LightTree::estimate(const Node& node, const Receiver& receiver, Estimates& to) noexcept
{
    constexpr float kMostWrong = 16;
    constexpr float kLeastDistance2 = 1e-24f;  // power over it must not overflow
    const Lanes3 normal = in_all_lanes(receiver.normal), normal_size = abs(normal);
    const vfloat zero(0.0f);
    for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes)) {
        const Lanes3 off = Lanes3::load(node.middle, k) - receiver.point, half = Lanes3::load(node.half, k);
        const Lanes3 near_off = (abs(off) - half).positive(), far_off = abs(off) + half;
        const vfloat near2 = dot(near_off, near_off), far2 = dot(far_off, far_off);
        // Within the ball around the lights their power counts as if it stood at its border.
        const vfloat distance2 = max(max(dot(off, off), dot(half, half)), vfloat(kLeastDistance2));
        const vfloat distance = sqrt(distance2), inverse = vfloat(1.0f) / distance;

        vfloat height = dot(off, normal);
        if (receiver.is_two_sided) height = abs(height);
        const vfloat height_half = dot(half, normal_size);
        vmask dark = height + height_half < vfloat(-kBelowSurface) * distance;
        const vfloat facing = clamped(mean_above_zero(height, height_half) * inverse, kMargin, 1);

        const Lanes3 axis = Lanes3::load(node.axis, k);
        const vfloat along = -dot(off, axis);
        const vfloat ahead = select(vfloat::load(node.is_two_sided + k) > zero, abs(along), along);
        const vfloat ahead_half = dot(half, abs(axis)), cos_end = vfloat::load(node.cos_end + k);
        // The bound of the cosine is that of the nearest place of the box, or, where it is below zero, of the farthest.
        const vfloat most_ahead = ahead + ahead_half, most2 = most_ahead * most_ahead, end2 = cos_end * cos_end;
        const vmask is_wide = cos_end < zero, is_behind = most_ahead < zero;
        dark = dark | (is_wide & is_behind & (most2 > end2 * far2)) | andnot(is_behind | (most2 < end2 * near2), is_wide);
        const vfloat cosine = clamped(mean_above_zero(ahead, ahead_half) * inverse, -1, 1);
        const vfloat cos_axis = vfloat::load(node.cos_axis + k), sin_axis = vfloat::load(node.sin_axis + k);
        const vfloat nearest = cosine * cos_axis + sine_of(cosine) * sin_axis;  // to any direction in the cone
        const vfloat turned = select(cosine >= cos_axis, vfloat(1.0f), clamped(nearest, kMargin, 1));

        const vfloat power = vfloat::load(node.power + k);
        dark = dark | (near2 > vfloat::load(node.range2 + k)) | (power <= zero);
        const vfloat given = clamped(power * inverse * inverse * (facing * turned), kLeastPower, kMostPower);
        const vfloat light = select(dark, zero, given);
        light.store(to.light + k);
        // All power may lie where the box is nearest.
        const vfloat nearer = min(distance2 / near2, vfloat(kMostWrong));
        (light * nearer * vfloat::load(node.is_subtree + k)).store(to.doubt + k);
    }
    if (!node.has_groups && receiver.groups != 0) return;
    for (std::size_t k = 0; k < kWide; ++k)
        if ((node.groups[k] & receiver.groups) == 0) to.light[k] = to.doubt[k] = 0;
}

// The parts into which the tree is divided for a receiver: the children of some nodes, one node in each row. A child that
// is divided further gives nothing by itself.
class LightTree::Parts {
public:
    static constexpr std::size_t kNone = ~std::size_t(0);

    /// draws   lights that are drawn at most
    explicit Parts(int draws) noexcept : draws_(std::clamp(draws, 1, kMostDraws)), least_share_(2 / float(draws_)) {}

    std::size_t rows() const noexcept { return rows_; }
    Place place(std::size_t row, std::size_t column) const noexcept
    {
        return nodes_[row] * std::uint32_t(kWide) + static_cast<std::uint32_t>(column);
    }
    // Adds a row for a node, which is not the last that there is room for.
    void add(const LightTree& tree, std::uint32_t node, const Receiver& receiver) noexcept
    {
        nodes_[rows_] = node;
        estimate(tree.nodes_[node], receiver, of_[rows_]);
        most_doubt_[rows_] = most_doubt_in(rows_);
        sum_ += of_[rows_].sum();
        ++rows_;
    }
    // Returns the part that is to be divided next, which counts no longer, or kNowhere if there is no room for more or
    // nothing in doubt is left that matters.
    Place take_next() noexcept
    {
        std::size_t row = 0;
        for (std::size_t i = 1; i < rows_; ++i)
            if (most_doubt_[i] > most_doubt_[row]) row = i;
        const float most = most_doubt_[row];
        if (rows_ == kMostRows || !(most > sum_ * least_share_)) return kNowhere;
        std::size_t column = 0;
        while (of_[row].doubt[column] != most) ++column;
        sum_ -= of_[row].light[column];
        of_[row].light[column] = of_[row].doubt[column] = 0;
        most_doubt_[row] = most_doubt_in(row);
        return place(row, column);
    }
    // Decides the chances, once all is divided: from a part with more than a certain share of all light a light is drawn for
    // sure, and from others in proportion. That share is half of what one draw stands for, or all of it if half would lead
    // to too many draws. If the others have few chances then, since light that may be hidden outshines them by far, they
    // get some of what is left.
    void finish() noexcept
    {
        float all = kLeastPower;
        for (std::size_t row = 0; row < rows_; ++row) all += of_[row].sum();
        const float most = 1 / float(draws_);
        if (set_chances(1 / (all * most * 0.5f)) > float(draws_)) set_chances(1 / (all * most));
        Uncertain others;
        for (std::size_t row = 0; row < rows_; ++row) add_uncertain(row, others);
        const float due = std::min(float(draws_) * kDueToOthers, float(draws_) - others.certain);
        if (others.light > 0 && others.chances < due) set_chances(due / others.light);
    }
    // Returns the chance with which a light is drawn from a part, and the sum of those of a row.
    float chance(std::size_t row, std::size_t column) const noexcept { return chance_[row][column]; }
    float chances(std::size_t row) const noexcept { return chances_[row]; }
    // Returns the row of a node, or kNone if it has none.
    std::size_t row_of(std::uint32_t node) const noexcept
    {
        const auto end = nodes_.begin() + std::ptrdiff_t(rows_), found = std::find(nodes_.begin(), end, node);
        return found == end ? kNone : static_cast<std::size_t>(found - nodes_.begin());
    }

private:
    static constexpr std::size_t kMostRows = 10;
    static constexpr float kDueToOthers = 1.0f / 8;  // of all draws

    struct Uncertain {
        float certain = 0;             // parts from which a light is drawn for sure
        float chances = 0, light = 0;  // sums over the others
    };
    void add_uncertain(std::size_t row, Uncertain& to) const noexcept
    {
        const vfloat one(1.0f), zero(0.0f);
        float certain[kWide], light[kWide];
        for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes)) {
            const vmask is_certain = vfloat::load(chance_[row] + k) >= one;
            select(is_certain, one, zero).store(certain + k);
            select(is_certain, zero, vfloat::load(of_[row].light + k)).store(light + k);
        }
        const float sure = sum_of(certain);
        to.certain += sure;
        to.chances += chances_[row] - sure;
        to.light += sum_of(light);
    }
    // Gives each part a chance in proportion to its light, of at most 1, and returns the sum of all.
    float set_chances(float scale) noexcept
    {
        float sum = 0;
        for (std::size_t row = 0; row < rows_; ++row) {
            for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes))
                min(vfloat::load(of_[row].light + k) * vfloat(scale), vfloat(1.0f)).store(chance_[row] + k);
            chances_[row] = sum_of(chance_[row]);
            sum += chances_[row];
        }
        return sum;
    }

    float most_doubt_in(std::size_t row) const noexcept
    {
        vfloat most = vfloat::load(of_[row].doubt);
        for (std::size_t k = std::size_t(kLanes); k < kWide; k += std::size_t(kLanes))
            most = max(most, vfloat::load(of_[row].doubt + k));
        return highest(most);
    }

    int draws_;
    float least_share_;  // a part is not divided if the light that is in doubt is a smaller share of all
    std::size_t rows_ = 0;
    std::array<std::uint32_t, kMostRows> nodes_;
    std::array<Estimates, kMostRows> of_;
    float sum_ = 0;                // of the estimates of all parts, but for rounding
    float most_doubt_[kMostRows];  // of the parts of each row
    float chance_[kMostRows][kWide], chances_[kMostRows];
};

LightTree::Parts LightTree::divide(const Receiver& receiver, int draws) const noexcept
{
    Parts parts(draws);
    parts.add(*this, 0, receiver);
    for (Place next = parts.take_next(); next != kNowhere; next = parts.take_next()) parts.add(*this, below(next), receiver);
    parts.finish();
    return parts;
}

bool LightTree::draw_below(std::uint32_t node, const Receiver& receiver, double number, Pick& pick) const noexcept
{
    Estimates of;
    float probability = 1;
    while (true) {
        const Node& at = nodes_[node];
        estimate(at, receiver, of);
        const float sum = of.sum();
        if (!(sum > 0)) return false;
        const double wanted = number * double(sum);
        double before = 0, passed = 0;
        std::uint32_t chosen = 0;
        // Rounding may leave the number above the sum: the last child that gives light is chosen then.
        for (std::uint32_t k = 0; k < at.children; ++k) {
            if (!(of.light[k] > 0)) continue;
            chosen = k;
            before = passed;
            passed += double(of.light[k]);
            if (wanted < passed) break;
        }
        number = std::clamp((wanted - before) / double(of.light[chosen]), 0.0, kBelowOne);
        probability *= of.light[chosen] / sum;
        if (!(at.is_subtree[chosen] > 0)) {
            pick = {at.below[chosen], probability, static_cast<float>(number)};
            return true;
        }
        node = at.below[chosen];
    }
}

int LightTree::draw(const Receiver& receiver, float number, std::span<Pick> picks) const noexcept
{
    if (nodes_.empty() || picks.empty()) return 0;
    if (picks.size() == 1) return draw_below(0, receiver, double(number), picks.front()) ? 1 : 0;
    constexpr double kGoldenRatio = 0.6180339887498949;
    const Parts parts = divide(receiver, static_cast<int>(picks.size()));
    std::size_t count = 0;
    // A part is drawn from where the sum of the number and of the chances so far passes a whole number. By how much is a
    // number for the choice within the part; those of neighbouring parts are moved apart.
    double sum = double(number);
    for (std::size_t row = 0; row < parts.rows(); ++row) {
        if (const double after = sum + double(parts.chances(row)); after < kBelowOne) {
            sum = after;
            continue;
        }
        for (std::size_t column = 0; column < kWide; ++column) {
            const float chance = parts.chance(row, column);
            sum += double(chance);
            // Rounding of the chances may not give more picks than there is room for.
            if (sum < 1 || count == picks.size()) continue;
            sum -= 1;
            const double apart = kGoldenRatio * double(row * kWide + column);
            const double shifted = std::min(sum / double(chance), kBelowOne) + apart;
            const double within = std::min(shifted - std::floor(shifted), kBelowOne);
            const Place place = parts.place(row, column);
            Pick& pick = picks[count];
            const bool is_alone = is_light(place);
            if (is_alone) pick = {below(place), 1, static_cast<float>(within)};
            if (is_alone || draw_below(below(place), receiver, within, pick)) {
                pick.expected *= chance;
                ++count;
            }
        }
    }
    return static_cast<int>(count);
}

float LightTree::expected(std::uint32_t light, const Receiver& receiver, int draws) const noexcept
{
    Place at = place_of_[light - first_];
    if (at == kNowhere) return 0;
    const Parts parts = draws > 1 ? divide(receiver, draws) : Parts(draws);
    float product = 1;
    while (true) {
        const std::uint32_t node = at / std::uint32_t(kWide);
        if (const std::size_t row = parts.row_of(node); row != Parts::kNone) return product * parts.chance(row, at % kWide);
        Estimates of;
        estimate(nodes_[node], receiver, of);
        const float own = of.light[at % kWide];
        if (!(own > 0)) return 0;
        product *= own / of.sum();
        if (node == 0) return product;
        at = nodes_[node].place;
    }
}

unsigned LightTree::crossed(const Node& node, Vec3f origin, Vec3f inverse) noexcept
{
    unsigned found = 0;
    for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes)) {
        const Lanes3 middle = Lanes3::load(node.middle, k) - origin, half = Lanes3::load(node.half, k);
        const Lanes3 low = middle - half, high = middle + half;
        const vfloat ax = low.x * vfloat(inverse.x), bx = high.x * vfloat(inverse.x);
        const vfloat ay = low.y * vfloat(inverse.y), by = high.y * vfloat(inverse.y);
        const vfloat az = low.z * vfloat(inverse.z), bz = high.z * vfloat(inverse.z);
        const vfloat t_in = max(max(max(min(ax, bx), min(ay, by)), min(az, bz)), vfloat(0.0f));
        const vfloat t_out = min(min(max(ax, bx), max(ay, by)), max(az, bz));
        const vmask enters = (t_in <= t_out * vfloat(1 + 0x1p-20f)) & (vfloat::load(node.reach2 + k) > vfloat(0.0f));
        found |= bits(enters) << k;
    }
    return found;
}

unsigned LightTree::around(const Node& node, Vec3f at, float within) noexcept
{
    unsigned found = 0;
    for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes)) {
        const Lanes3 off = abs(Lanes3::load(node.middle, k) - at),
                     half = Lanes3::load(node.half, k) + in_all_lanes(Vec3f(within));
        const vmask holds = (off.x <= half.x) & (off.y <= half.y) & (off.z <= half.z);
        found |= bits(holds & (vfloat::load(node.power + k) > vfloat(0.0f))) << k;
    }
    return found;
}

unsigned LightTree::covering(const Node& node, Vec3f at, float share) noexcept
{
    unsigned found = 0;
    for (std::size_t k = 0; k < kWide; k += std::size_t(kLanes)) {
        const Lanes3 off = Lanes3::load(node.middle, k) - at, half = Lanes3::load(node.half, k);
        const Lanes3 outside = (abs(off) - half).positive();
        const vfloat reach2 = vfloat::load(node.reach2 + k);
        const vmask is_small = reach2 < vfloat(share * 0.999f) * dot(outside, outside);
        found |= bits(andnot(reach2 > vfloat(0.0f), is_small)) << k;
    }
    return found;
}

}  // namespace occam::shade
