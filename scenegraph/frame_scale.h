// The unit of length in which a frame is computed: the world's, times a power of two.
//
// Everything that enters a frame is converted to its unit, in which the largest side of the scene's bounds is from 1 to 2:
// placements, cameras, lights and rays. What leaves the frame is converted back. So floats neither overflow nor underflow,
// whatever the size of the scene, and a picture has the same bits for every power of two by which a scene is scaled.
//
// Space    "frame lengths" and "frame axes" are those of the world, scaled about the world's origin.
// Threads  const after construction.
#pragma once

#include "base/box.h"
#include "base/power_of_two.h"
#include "scenegraph/camera.h"

namespace occam {

class FrameScale {
public:
    /// Computes in world lengths.
    FrameScale() = default;
    /// Chooses the unit for a scene with these bounds. Bounds without an extent, or without a finite one, give world
    /// lengths.
    explicit FrameScale(const Box3d& world_bounds) noexcept;

    /// One frame length is 2^exponent() world lengths; a level of the frame is that many levels coarser in the world.
    int exponent() const noexcept { return exponent_; }
    double to_frame() const noexcept { return power_of_two_double(-exponent_); }  ///< frame lengths of a world length
    double to_world() const noexcept { return power_of_two_double(exponent_); }   ///< world lengths of a frame length
    /// Converts a length or a coordinate.
    float to_frame(float world) const noexcept { return static_cast<float>(double(world) * to_frame()); }
    float to_world(float frame) const noexcept { return static_cast<float>(double(frame) * to_world()); }

    /// Returns the matrix of a placement, in frame lengths.
    Mat4d placed(const Mat4d& world_from_node) const noexcept;
    Camera placed(const Camera& camera) const noexcept;
    Box3d placed(const Box3d& world) const noexcept { return {world.lo * to_frame(), world.hi * to_frame()}; }

private:
    int exponent_ = 0;
};

}  // namespace occam
