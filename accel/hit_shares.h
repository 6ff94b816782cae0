// Computes where in its micropolygon a ray hits: the weights of the corners, in lanes.
#pragma once

#include "accel/hit_rays.h"

namespace occam::accel {

/// Refers to rays in lanes.
struct RaysThatHit {
    const RayAxes& axes;
    std::span<const Ray> rays;
    const HitRays& placed;  ///< the same rays in lanes, each in the frame of its cage
    unsigned gaps;          ///< lanes that met gap triangles, which have no edge functions
};

/// Computes the barycentric weights of the corners at the hits, from the same edge functions that found the hits: those of a
/// cage's still pose, if it is hit there. So they are never negative, however thin the triangle looks.
void shares_of(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept;

inline Vec4f weighted(const Vec4f (&of)[3], Vec3f w) noexcept { return of[0] * w.x + of[1] * w.y + of[2] * w.z; }

}  // namespace occam::accel
