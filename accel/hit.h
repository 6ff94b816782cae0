// Fills hits with what phase two of shading needs of them, by value.
#pragma once

#include <span>

#include "accel/grid_hit.h"
#include "accel/phase_one.h"
#include "accel/ray_lanes.h"
#include "accel/surface_hit.h"

namespace occam::accel {

/// Fills `hits` from the micropolygons that up to kLanes rays of a group have hit. Runs phase one on patches that have
/// their first hits here. Hits of rays that missed are not written.
/// are_first   false if the rays have passed other surfaces since t_near
void resolve(std::span<const Ray> rays, const RayAxes& axes, std::span<const GridHit> met, const PhaseOneTools& tools,
             SurfaceHit* const* hits, bool are_first = true);

/// Returns what SurfaceHit::back_side is for the hit of a ray if it is the ray's first. Phase one has run there.
bool is_back_side(const Ray& ray, const RayAxes& axes, const GridHit& met, const FrameState& frame) noexcept;

}  // namespace occam::accel
