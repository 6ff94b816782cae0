// Direct light at a point: what would arrive from a light or along a scattered direction, and the ray that decides.
//
// Light is looked for in two ways, by drawing points of lights and by drawing directions from the surface's lobes; what both
// can find is weighted by the expected numbers of samples of either (balance heuristic, Veach and Guibas 1995, eq. 9).
//
// A light that scattered directions would hardly ever find is left to its own samples: it counts as if no direction were
// scattered, so that its samples weigh 1 and what a scattered ray finds of it weighs 0, and where all lights are of that
// kind nothing is scattered to find them. Weights have to be no more than the same on either side (Veach and Guibas 1995,
// sec. 3.2): the rule looks at surface, eye and light, never at a sample. It costs no noise: FrameLights::kLeastChance.
#pragma once

#include "shade/bsdf.h"
#include "shade/frame_lights.h"

namespace occam::shade {

/// The caller traces from `origin` along `direction` to `t_far`; if nothing is met, `radiance` leaves towards the eye.
struct ShadowTest {
    Vec3d origin{0};
    Vec3f direction{0};
    float t_far = 0;
    Vec3f radiance{0};  ///< zero: nothing to trace
    float density = 0;  ///< that the light is drawn with, per solid angle; 0: it has no extent
};

/// How often either way is tried at a point, in expectation.
struct Tries {
    float lights = 1;   ///< samples of the light in question
    float scatter = 1;  ///< directions drawn from the lobes; 0 for a light that is left to its own samples

    /// Weight of a sample that was drawn with `own` density and could have been drawn with `other`.
    static float weight(float own_tries, float own, float other_tries, float other) noexcept
    {
        return own > 0 ? own_tries * own / (own_tries * own + other_tries * other) : 0;
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

/// What a sample of a light brings. Lights that scattered directions cannot meet get all of the weight.
inline ShadowTest test_of(const Surface& surface, const LightSample& sample, Tries tries) noexcept
{
    if (sample.radiance == Vec3f(0)) return {};
    const Vec3f f = scatter(surface, sample.direction);
    if (f == Vec3f(0)) return {};
    const bool is_weighed = sample.density > 0 && tries.scatter > 0;
    const float weight = is_weighed ? tries.of_light(sample.density, scatter_density(surface, sample.direction)) : 1;
    return {surface.start(sample.direction), sample.direction, sample.distance, f * sample.radiance * weight,
            sample.density};
}

/// One sample each.
ShadowTest test_meshes(const Surface& surface, const MeshLights& lights, LightNumbers numbers, Tries tries) noexcept;
/// Nothing for an environment without a density of its own: then scattered directions find all of it.
ShadowTest test_environment(const Surface& surface, const Environment& environment, LightNumbers numbers,
                            Tries tries) noexcept;

}  // namespace occam::shade
