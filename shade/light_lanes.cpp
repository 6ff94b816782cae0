#include "shade/light_lanes.h"

#include <limits>

namespace occam::shade {
namespace {

VecLanes spread(Vec3f v) noexcept { return {v.x, v.y, v.z}; }

// Samples flat lights at places in [-1, 1] from side to side.
LightSampleLanes sample_flat(const WorldLight& light, const VecLanes& to_middle, vfloat x, vfloat y) noexcept
{
    const vfloat zero = 0.0f, one = 1.0f;
    const VecLanes to_light = to_middle + spread(light.half_x) * x + spread(light.half_y) * y;
    const vfloat distance2 = max(vfloat(kMinDistance2), dot(to_light, to_light)), distance = sqrt(distance2);
    const VecLanes towards = to_light * (one / distance);
    vfloat cosine = -dot(towards, spread(light.direction));
    if (light.two_sided) cosine = abs(cosine);
    const vfloat solid_angle = light.area * cosine / distance2;
    const vfloat end = LightGap::end(distance, cosine, vfloat(LightGap::across(light.area)));
    const vmask shines = (cosine > zero) & (solid_angle > zero) & (end > zero);
    return {towards, end, select(shines, spread(light.strength) * solid_angle, spread(Vec3f(0))),
            select(shines, one / solid_angle, zero)};
}

LightSampleLanes sample_point(const WorldLight& light, const VecLanes& to_light) noexcept
{
    const vfloat zero = 0.0f, one = 1.0f;
    const vfloat distance2 = max(vfloat(kMinDistance2), dot(to_light, to_light)), distance = sqrt(distance2);
    const vmask is_in_range = distance2 < vfloat(std::numeric_limits<float>::infinity());
    const VecLanes direction = divided(to_light, distance);
    const vfloat along = -dot(direction, spread(light.direction));
    const vfloat cone = clamp(along * light.spot_scale + light.spot_offset, zero, one);
    vfloat fall = cone * cone / distance2;
    if (light.range > 0) {
        const vfloat share = distance2 / (light.range * light.range);
        fall = fall * clamp(one - share * share, zero, one);
    }
    const VecLanes light_here = spread(light.strength) * fall;
    const vfloat most = kMostOfAPoint;
    const VecLanes limited{min(light_here.x, most), min(light_here.y, most), min(light_here.z, most)};
    return {direction, LightGap::end(distance), select(is_in_range, limited, spread(Vec3f(0))), zero};
}

LightSampleLanes sample_sun(const WorldLight& light, vfloat u, vfloat v) noexcept
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    if (!(light.sun_spread > 0)) return {spread(-light.direction), kInfinity, spread(light.strength), 0.0f};
    const ShadingFrame axes(-light.direction);
    const DiscPoints d(u, v);
    const vfloat one = 1.0f, x = d.x * light.sun_spread, y = d.y * light.sun_spread;
    const vfloat distance2 = x * x + y * y + one, distance = sqrt(distance2);
    const VecLanes direction = (spread(axes.x) * x + spread(axes.y) * y + spread(axes.z) * one) * (one / distance);
    return {direction, kInfinity, spread(light.strength),
            distance2 * distance / vfloat(kPi * light.sun_spread * light.sun_spread)};
}

}  // namespace

LaneVectors LanePoints::to(Vec3d place) const noexcept
{
    LaneVectors v;
    for (int i = 0; i < kLanes; ++i) v.x.of[i] = static_cast<float>(place.x - x[i]);
    for (int i = 0; i < kLanes; ++i) v.y.of[i] = static_cast<float>(place.y - y[i]);
    for (int i = 0; i < kLanes; ++i) v.z.of[i] = static_cast<float>(place.z - z[i]);
    return v;
}

LightSampleLanes sample_from(const WorldLight& light, const LaneVectors& to_middle, const LaneFloats& u,
                             const LaneFloats& v) noexcept
{
    using Kind = WorldLight::Kind;
    const bool is_flat = (light.kind == Kind::Rectangle || light.kind == Kind::Disc) && !light.is_long;
    if (is_flat && light.kind == Kind::Rectangle)
        return sample_flat(light, to_middle.lanes(), u.lanes() * 2.0f - 1.0f, v.lanes() * 2.0f - 1.0f);
    if (is_flat) {
        const DiscPoints d(u.lanes(), v.lanes());
        return sample_flat(light, to_middle.lanes(), d.x, d.y);
    }
    if (light.kind == Kind::Point) return sample_point(light, to_middle.lanes());
    if (light.kind == Kind::Sun) return sample_sun(light, u.lanes(), v.lanes());
    LightSamples samples;
    for (int i = 0; i < kLanes; ++i) samples.set(i, light.sample_from(to_middle.at(i), {Vec2f(u.of[i], v.of[i])}));
    return samples.lanes();
}

vmask is_left_to_samples(const WorldLight& light, const VecLanes& to_middle, vfloat peak) noexcept
{
    const vfloat sine2 = light.kind == WorldLight::Kind::Sun ? vfloat(light.sine2_subtended(Vec3d(0)))
                                                             : light.size2() / dot(to_middle, to_middle);
    return sine2 * (peak * kPi) < vfloat(FrameLights::kLeastChance);
}

}  // namespace occam::shade
