// Says what the levels of a ray depend on, except for the interval in which it is in the scene.
#pragma once

#include "accel/frame_state.h"
#include "accel/ray.h"

namespace occam::accel {

/// Returns the target edge lengths by which a ray's levels are chosen. A ray without a width takes the camera's.
inline lod::Footprint target_edge_of(const Ray& ray, const lod::LevelSettings& levels) noexcept
{
    lod::Footprint f = ray.footprint;
    if (f.a <= 0 && f.b == 0)
        f = {levels.pixel.at(static_cast<float>(glm::distance(ray.origin, levels.eye))), levels.pixel.b};
    if (levels.mode == lod::LevelMode::Frozen && !(ray.kinds & RayKind::Camera)) f.b = 0;
    return levels.target_edge(f);
}

/// Holds the inputs of a ray's table of transitions (lod::RayLevels); a packet gathers them four at a time.
struct RayReach {
    lod::Footprint target_edge;
    float coordinate;  ///< the largest coordinate of the ray's origin in the tree's frame; it bounds rounding errors
    float start;       ///< edge length of the ray's start level; 0 if it has none
    float focus;       ///< Ray::focus
};
inline RayReach reach_of(const Ray& ray, const FrameState& frame) noexcept
{
    return {target_edge_of(ray, frame.levels), static_cast<float>(glm::distance(ray.origin, frame.anchor)),
            ray.start_level == kAnyLevel ? 0.0f : lod::edge_length(ray.start_level), ray.focus};
}

}  // namespace occam::accel
