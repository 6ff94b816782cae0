// Recognizes gaps between two levels that come from rounding alone and are seen by rays that graze the surface.
//
// On either side of a transition a ray sees the same surface, except for the rounding of the vertices that only one of
// the two levels has. A rounding error r separates the hits of a ray that hits the surface at an angle a by r / sin(a)
// along the ray. So a ray at a small enough angle passes between two segments that overlap by a few ulps, which is how
// closed cages are tested. The engine's own overlap, a tenth of an edge, closes such a gap.
#pragma once

#include <memory>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/ray_levels.h"

namespace occam {

/// Traces rays again as the engine does. It borrows the scene and its tables.
class GrazingRays {
public:
    /// levels   are set as in the engine, with its overlap.
    GrazingRays(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                const TextureStore* textures, float radius);

    /// Returns whether a ray that left the surface hits its back with the engine's overlap, no farther from a transition
    /// of `table` than the rounding of vertices explains at the angle at which the ray hits the surface.
    /// table   is the ray's table, already made, with the overlap with which it was traced.
    bool explain(const accel::Ray& ray, const lod::RayLevels<float>& table);

private:
    accel::Frame frame_;
    accel::Tracer tracer_;
    float radius_;
};

}  // namespace occam
