// Direct light at a point: what would arrive from a light or along a scattered direction, and the ray that decides
// whether it does.
//
// Light is sampled in two ways: by drawing points on lights and by drawing directions from the lobes of the surface. What
// both can find is weighted by the expected numbers of samples of either (balance heuristic, Veach and Guibas 1995, eq.
// 9).
//
// A light that scattered directions would hardly ever find is left to its own samples. It counts as if no direction were
// scattered: its samples weigh 1, and what a scattered ray finds of it weighs 0. Where all lights are of that kind, no
// ray is scattered to find them. The estimate stays unbiased as long as both techniques use the same weights (Veach and
// Guibas 1995, sec. 3.2): the rule depends on the surface, the eye and the light, never on a sample. It adds no noise;
// see FrameLights::kLeastChance.
#pragma once

#include <cmath>
#include <limits>

#include "shade/bsdf.h"
#include "shade/frame_lights.h"

namespace occam::shade {

/// Describes a shadow ray. The caller traces from `origin` along `direction` to `t_far`; if nothing is hit, `radiance`
/// leaves towards the eye.
struct ShadowTest {
    Vec3d origin{0};
    Vec3f direction{0};
    float t_far = 0;
    Vec3f radiance{0};                     ///< zero: there is nothing to trace
    float density = 0;                     ///< density of the light's sample per solid angle; 0: the light has no extent
    std::uint8_t kinds = RayKind::Shadow;  ///< of the ray
};

/// Holds the expected number of samples of each technique of multiple importance sampling at a point.
struct SampleCounts {
    float lights = 1;   ///< samples of the light in question
    float scatter = 1;  ///< directions drawn from the lobes; 0 for a light that is left to its own samples

    /// Returns the weight of a sample that was drawn with density `own` and could have been drawn with density `other`. It
    /// is 1 where floats do not hold the own density, as that of a light which is very small.
    static float weight(float own_count, float own, float other_count, float other) noexcept
    {
        const float mine = own_count * own;
        if (!(mine < std::numeric_limits<float>::infinity())) return 1;
        return own > 0 ? mine / (mine + other_count * other) : 0;
    }
    float of_light(float light_density, float scatter_density) const noexcept
    {
        return light_density > 0 ? weight(lights, light_density, scatter, scatter_density) : 1;
    }
    float of_scatter(float scatter_density, float light_density) const noexcept
    {
        return weight(scatter, scatter_density, lights, light_density);
    }
};

/// Returns the ray that decides whether a sample of a light arrives, without what it brings. The sample is drawn for
/// Surface::front_start(). A ray to the other side starts elsewhere, and leads to the same point of the light.
inline ShadowTest ray_to(const Surface& surface, const LightSample& sample) noexcept
{
    const Vec3d start = surface.start(sample.direction);
    ShadowTest ray{start, sample.direction, sample.distance, Vec3f(0), sample.density, sample.kinds};
    const Vec3d aside = surface.front_start() - start;
    if (aside == Vec3d(0) || !std::isfinite(sample.distance)) return ray;
    const Vec3d way = Vec3d(sample.direction) * double(sample.distance) + aside;
    const double length = glm::length(way);
    if (!(length > 0)) return ray;
    ray.direction = Vec3f(way / length);
    ray.t_far = static_cast<float>(length);
    return ray;
}

/// Returns what a sample of a light contributes. Lights that scattered directions cannot find get the full weight.
/// sample   drawn for Surface::front_start()
inline ShadowTest test_of(const SurfaceForEye& surface, const LightSample& sample, SampleCounts counts) noexcept
{
    if (sample.radiance == Vec3f(0)) return {};
    const bool is_weighed = sample.density > 0 && counts.scatter > 0;
    const ScatterWithDensity f = is_weighed ? scatter_with_density(surface, sample.direction)
                                            : ScatterWithDensity{scatter(surface, sample.direction), 0};
    if (f.light == Vec3f(0)) return {};
    const float weight = is_weighed ? counts.of_light(sample.density, f.density) : 1;
    ShadowTest test = ray_to(surface.surface, sample);
    test.radiance = f.light * sample.radiance * weight;
    return test;
}

/// Returns a light from infinitely far as a sample of it; black if it has no density.
LightSample sample_of(const Environment::Light& light) noexcept;
/// Draws one sample of the emissive triangles for a receiver.
ShadowTest test_meshes(const SurfaceForEye& surface, const MeshLights& lights, const Receiver& receiver,
                       LightNumbers numbers, SampleCounts counts) noexcept;
/// Draws one sample of the environment; returns nothing for an environment without a density of its own, since scattered
/// directions then find all of its light.
ShadowTest test_environment(const SurfaceForEye& surface, const Environment& environment, LightNumbers numbers,
                            SampleCounts counts) noexcept;

}  // namespace occam::shade
