// Direct light at a point, one sample of one light at a time: what would arrive, and the ray that decides whether it does.
#pragma once

#include "shade/bsdf.h"
#include "shade/lights.h"

namespace occam::shade {

/// The caller traces from `origin` along `direction` to `t_far`; if nothing is met, `radiance` leaves towards the eye.
struct ShadowTest {
    Vec3d origin{0};
    Vec3f direction{0};
    float t_far = 0;
    Vec3f radiance{0};  ///< zero: nothing to trace
};

ShadowTest sample_light(const Surface& surface, const WorldLight& light, LightNumbers numbers) noexcept;

/// One sample: by the environment's own brightness if it is an image, or by the surface's lobes.
ShadowTest sample_environment(const Surface& surface, const Environment& environment, LightNumbers numbers) noexcept;

}  // namespace occam::shade
