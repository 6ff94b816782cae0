// What the integrator keeps of a ray that is on its way, beside the ray.
#pragma once

#include <cstdint>

#include "base/vec.h"
#include "scenegraph/ray_kind.h"

namespace occam::render {

/// A piece of a sample's light that is still being looked for.
struct Path {
    std::uint32_t sample = 0;  ///< of the batch
    std::uint32_t key = 0;     ///< names the random numbers of the next surface: of its own for every branch of a sample
    Vec3f throughput{1};       ///< of what it finds, this reaches the pixel
    float coverage = 1;        ///< share of the pixel that nothing before covers; 0 once the path was scattered
    float density = 0;         ///< of the scattered direction per solid angle; 0: a camera ray
    float peak = 0;            ///< shade::peak_density() of the surface that scattered it
    float light_tries = 1, scatter_tries = 1;  ///< samples of either kind at the surface it comes from
    Vec3f absorption{0};                       ///< of the body that it travels in, per world length
    LightGroups lit_by = kAllGroups;           ///< of the surface that scattered it
    std::uint8_t bounces = 0;                  ///< surfaces that scattered it
    std::uint8_t splits = 0;                   ///< Counts the surfaces that split the camera's ray in two, up to kMaxSplits.
    bool is_probe = false;                     ///< looks for light, and is scattered no more
    bool is_before_focus = false;  ///< of a lens: the ray ends at the focus, and goes on behind it with another footprint

    bool is_camera() const noexcept { return bounces == 0; }
};

/// Rays traced, by what they were for.
struct RayCounters {
    std::uint64_t primary = 0, shadow = 0, ao = 0, glossy = 0, diffuse = 0;
};

}  // namespace occam::render
