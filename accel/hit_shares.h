// Computes where in its micropolygon a ray hits: the weights of the corners, in lanes.
#pragma once

#include "accel/corners.h"

namespace occam::accel {

/// Computes the barycentric weights of the corners at the hits, from the same edge functions that found the hits. Gap
/// triangles, which have no edge functions, are the lanes of `gaps`.
/// way, origin   of the rays, each in the frame of its cage
void shares_of(const HitCorners& corners, const RayAxes& axes, std::span<const Ray> rays, std::span<const GridHit> met,
               const vfloat (&way)[4], const vfloat (&origin)[4], unsigned gaps, vfloat (&share)[3]) noexcept;

inline Vec4f weighted(const Vec4f (&of)[3], Vec3f w) noexcept { return of[0] * w.x + of[1] * w.y + of[2] * w.z; }

}  // namespace occam::accel
