// Samples of lights for several surfaces side by side, with the bits of those for one.
#pragma once

#include <array>

#include "shade/frame_lights.h"
#include "shade/surface_lanes.h"

namespace occam::shade {

/// Holds a point for each lane, as the difference to another place is taken in double.
struct LanePoints {
    double x[kLanes], y[kLanes], z[kLanes];

    void set(int lane, Vec3d p) noexcept { x[lane] = p.x, y[lane] = p.y, z[lane] = p.z; }
    /// Returns the vectors from the points to a place.
    LaneVectors to(Vec3d place) const noexcept;
};

/// Samples a light like WorldLight::sample_from().
/// u, v   LightNumbers::square of each lane
LightSampleLanes sample_from(const WorldLight& light, const LaneVectors& to_middle, const LaneFloats& u,
                             const LaneFloats& v) noexcept;

/// Returns FrameLights::is_left_to_samples() of a light with an extent.
/// to_middle   from where rays leave the surfaces
vmask is_left_to_samples(const WorldLight& light, const VecLanes& to_middle, vfloat peak) noexcept;

/// Holds samples that are made one by one.
struct LightSamples {
    LaneVectors direction, radiance;
    LaneFloats distance, density;
    std::array<std::uint8_t, kLanes> kinds{};

    void set(int lane, const LightSample& s) noexcept
    {
        direction.set(lane, s.direction);
        radiance.set(lane, s.radiance);
        distance.of[lane] = s.distance;
        density.of[lane] = s.density;
        kinds[std::size_t(lane)] = s.kinds;
    }
    LightSampleLanes lanes() const noexcept
    {
        return {direction.lanes(), distance.lanes(), radiance.lanes(), density.lanes()};
    }
    void operator=(const LightSampleLanes& s) noexcept
    {
        direction = s.direction;
        radiance = s.radiance;
        distance = s.distance;
        density = s.density;
    }
};

}  // namespace occam::shade
