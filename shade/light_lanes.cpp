#include "shade/light_lanes.h"

namespace occam::shade {
namespace {

VecLanes spread(Vec3f v) noexcept { return {v.x, v.y, v.z}; }

LightSampleLanes sample_rectangle(const WorldLight& light, const VecLanes& to_middle, vfloat u, vfloat v) noexcept
{
    const vfloat zero = 0.0f, one = 1.0f;
    const VecLanes to_light = to_middle + spread(light.half_x) * (u * 2.0f - one) + spread(light.half_y) * (v * 2.0f - one);
    const vfloat distance2 = max(vfloat(kMinDistance2), dot(to_light, to_light)), distance = sqrt(distance2);
    const VecLanes towards = to_light * (one / distance);
    vfloat cosine = -dot(towards, spread(light.direction));
    if (light.two_sided) cosine = abs(cosine);
    const vfloat solid_angle = light.area * cosine / distance2;
    const vmask shines = cosine > zero;
    return {towards, distance, select(shines, spread(light.strength) * solid_angle, spread(Vec3f(0))),
            select(shines, one / solid_angle, zero)};
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
    if (light.kind == WorldLight::Kind::Rectangle && !light.is_long)
        return sample_rectangle(light, to_middle.lanes(), u.lanes(), v.lanes());
    LightSamples samples;
    for (int i = 0; i < kLanes; ++i) samples.set(i, light.sample_from(to_middle.at(i), {Vec2f(u.of[i], v.of[i])}));
    return samples.lanes();
}

vmask is_left_to_samples(const WorldLight& light, const VecLanes& to_middle, vfloat peak) noexcept
{
    return light.size2() / dot(to_middle, to_middle) * (peak * kPi) < vfloat(FrameLights::kLeastChance);
}

}  // namespace occam::shade
