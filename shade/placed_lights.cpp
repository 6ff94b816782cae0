#include "shade/placed_lights.h"

#include <algorithm>
#include <bit>

namespace occam::shade {
namespace {

bool same_bits(float a, float b) noexcept { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }
bool same_bits(double a, double b) noexcept { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
template <class Vec>
bool same_vectors(const Vec& a, const Vec& b) noexcept
{
    return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

// The picture may not depend on what was rendered before, and zeros of either sign may give different bits.
bool is_same(const WorldLight& a, const WorldLight& b) noexcept
{
    return a.kind == b.kind && same_vectors(a.position, b.position) && same_vectors(a.direction, b.direction) &&
           same_vectors(a.half_x, b.half_x) && same_vectors(a.half_y, b.half_y) && same_bits(a.area, b.area) &&
           same_bits(a.radius, b.radius) && a.two_sided == b.two_sided && a.is_long == b.is_long && a.groups == b.groups &&
           same_vectors(a.strength, b.strength) && same_bits(a.range, b.range) && same_bits(a.spot_scale, b.spot_scale) &&
           same_bits(a.spot_offset, b.spot_offset) && same_bits(a.sun_spread, b.sun_spread);
}
static_assert(sizeof(WorldLight) == 112, "is_same() has to compare every member");

}  // namespace

PlacedLights::PlacedLights(std::vector<WorldLight> all, std::optional<Vec3d> middle)
    : lights(std::move(all)), outside_tree(lights.size())
{
    if (lights.size() > kMostWithoutTree) {
        const auto in_tree = std::stable_partition(
            lights.begin(), lights.end(), [](const WorldLight& light) { return light.kind == WorldLight::Kind::Sun; });
        outside_tree = static_cast<std::size_t>(in_tree - lights.begin());
        tree = LightTree(lights, outside_tree, middle);
        for (std::size_t i = outside_tree; i < lights.size(); ++i) places.add(lights[i].position);
    }
    for (std::uint32_t i = 0; i < outside_tree; ++i)
        if (lights[i].has_extent()) with_extent.push_back(i);
}

// Few lights are made anew: they need no tree, and their suns do not stand first.
LightGathering::LightGathering(KeptLights last)
    : last_(std::move(last)), is_comparing_(last_ && last_->lights.size() > PlacedLights::kMostWithoutTree)
{
}

bool LightGathering::is_next(const WorldLight& light) noexcept
{
    const bool is_sun = light.kind == WorldLight::Kind::Sun;
    const std::size_t next = is_sun ? same_suns_ : last_->outside_tree + same_others_;
    if (next >= (is_sun ? last_->outside_tree : last_->lights.size()) || !is_same(light, last_->lights[next])) return false;
    const std::size_t place = same_suns_ + same_others_;
    if (is_sun && place < PlacedLights::kMostWithoutTree) suns_ |= 1u << place;
    ++(is_sun ? same_suns_ : same_others_);
    return true;
}

// Few lights stay in the order in which they were gathered, so that order is restored for as many.
void LightGathering::stop_comparing()
{
    is_comparing_ = false;
    lights_.reserve(last_->lights.size() + 1);
    std::size_t sun = 0, other = last_->outside_tree;
    for (std::size_t i = 0; i < same_suns_ + same_others_; ++i) {
        const bool is_sun = i < PlacedLights::kMostWithoutTree ? (suns_ >> i & 1) != 0 : sun < same_suns_;
        lights_.push_back(last_->lights[is_sun ? sun++ : other++]);
    }
}

void LightGathering::add(const WorldLight& light)
{
    if (is_comparing_) {
        if (is_next(light)) return;
        stop_comparing();
    }
    lights_.push_back(light);
}

KeptLights LightGathering::finish(std::optional<Vec3d> middle)
{
    if (is_comparing_) {
        const bool are_same = same_suns_ + same_others_ == last_->lights.size();
        if (are_same && (last_->places.is_empty() || LightTree::origin_for(last_->places, middle) == last_->tree.origin()))
            return std::move(last_);
        stop_comparing();
    }
    return std::make_shared<const PlacedLights>(std::move(lights_), middle);
}

}  // namespace occam::shade
