// Gaps between two levels that come from rounding alone, seen by rays that graze the surface.
//
// On either side of a transition a ray sees the same surface, but for the rounding of the vertices that only one of the two
// levels has. Rounding of r parts the hits of a ray that meets the surface at an angle a by r / sin(a) along the ray. So a
// ray that is flat enough passes between two segments that overlap by a few ulps, which is how closed cages are tested; the
// engine's own overlap, a tenth of an edge, closes such a gap.
#pragma once

#include <memory>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/ray_levels.h"

namespace occam {

/// Traces rays again as the engine does. Borrows the scene and its tables.
class GrazingRays {
public:
    /// levels   as the engine has them, its overlap included
    GrazingRays(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
                const TextureStore* textures, float radius);

    /// Whether a ray that met nothing meets the surface with the engine's overlap, no farther from a transition of `table`
    /// than the rounding of vertices explains at the angle at which it meets the surface.
    /// table   of the ray, made, with the overlap that it was traced with
    bool explain(const accel::Ray& ray, const lod::RayLevels<float>& table);

private:
    accel::Frame frame_;
    accel::Tracer tracer_;
    float radius_;
};

}  // namespace occam
