// The state of a path: what the integrator keeps for a ray that is being followed, beside the ray itself.
#pragma once

#include <cstdint>

#include "base/vec.h"
#include "scenegraph/ray_kind.h"
#include "shade/light_tree.h"

namespace occam::render {

/// A path of a sample that still collects light.
struct Path {
    std::uint32_t sample = 0;  ///< index in the batch
    std::uint32_t key = 0;     ///< seeds the random numbers of the next surface; every branch of a sample has its own
    Vec3f throughput{1};       ///< share of the radiance it finds that reaches the pixel
    float coverage = 1;        ///< share of the pixel that nothing before it covers; 0 once the path was scattered
    float density = 0;         ///< density of the scattered direction per solid angle; 0 for a camera ray
    float peak = 0;            ///< shade::peak_density() of the surface that scattered it
    float light_samples = 1, scatter_samples = 1;  ///< samples of each technique at the surface it comes from
    Vec3f absorption{0};           ///< absorption coefficient of the body that it travels in, per world length
    shade::Receiver receiver;      ///< the surface that scattered it, as lights were chosen for it
    std::uint8_t tree_draws = 0;   ///< lights that were drawn there from the tree for each light sample
    std::uint16_t passed = 0;      ///< number of surfaces that the ray has passed straight on
    float stands_for = 1;          ///< number of rays: itself, and those led elsewhere where light may pass
    float straight = 1;            ///< share of the light that the surfaces passed straight on since the last scattering
    std::uint8_t bounces = 0;      ///< number of surfaces that scattered it
    std::uint8_t splits = 0;       ///< number of surfaces that split the camera ray in two, up to kMaxSplits
    bool is_probe = false;         ///< the path looks for light, and is not scattered again
    bool is_before_focus = false;  ///< the ray ends at the focus of a lens, and continues behind it with another footprint

    bool is_camera() const noexcept { return bounces == 0; }
};

/// Counts the rays that were traced, by their purpose.
struct RayCounters {
    std::uint64_t primary = 0, shadow = 0, ao = 0, glossy = 0, diffuse = 0;
};

}  // namespace occam::render
