// Tests rays against boxes, in lanes, and copies one ray of a packet to all lanes.
#pragma once

#include <cfloat>

#include "accel/ray_lanes.h"

namespace occam::accel {

/// Returns the lanes of rays whose line is in the slightly widened box between t_near and t_far.
/// near, far  select on each axis the plane of the box that the ray crosses first, and the other one.
/// begin      receives where the rays enter the box.
OCCAM_ALWAYS_INLINE vmask in_box(const RayLanes& ray, const vfloat (&near)[3], const vfloat (&far)[3], vfloat t_near,
                                 vfloat t_far, vfloat& begin) noexcept
{
    vfloat in = (near[0] - ray.origin[0]) * ray.inverse[0];
    vfloat out = (far[0] - ray.origin[0]) * ray.inverse[0];
    for (int a = 1; a < 3; ++a) {
        in = max(in, (near[a] - ray.origin[a]) * ray.inverse[a]);
        out = min(out, (far[a] - ray.origin[a]) * ray.inverse[a]);
    }
    // The interval is widened by four ulps of each t and of the shift, which is more than their rounding: culling must
    // never decide a hit.
    const vfloat slack = 4 * FLT_EPSILON;
    const vfloat pad_in = (abs(in) + abs(ray.shift)) * slack, pad_out = (abs(out) + abs(ray.shift)) * slack;
    begin = ray.shift + in - pad_in;
    return (in - pad_in <= out + pad_out) & (begin <= t_far) & (ray.shift + out + pad_out >= t_near);
}
OCCAM_ALWAYS_INLINE vmask in_box(const RayLanes& ray, const vfloat (&near)[3], const vfloat (&far)[3], vfloat t_near,
                                 vfloat t_far) noexcept
{
    vfloat begin;
    return in_box(ray, near, far, t_near, t_far, begin);
}

inline VertexBlend spread(const VertexBlend& rays, int lane) noexcept
{
    return {{spread(rays.d[0], lane), spread(rays.d[1], lane), spread(rays.d[2], lane)}, spread(rays.k, lane)};
}

/// Copies one ray of a packet to all lanes, without its blend.
OCCAM_ALWAYS_INLINE RayLanes spread(const RayLanes& rays, int lane) noexcept
{
    const auto all = [lane](const vfloat(&x)[3], vfloat(&to)[3]) {
        for (int a = 0; a < 3; ++a) to[a] = spread(x[a], lane);
    };
    RayLanes one;
    one.kx = rays.kx;
    one.ky = rays.ky;
    one.kz = rays.kz;
    one.sx = spread(rays.sx, lane);
    one.sy = spread(rays.sy, lane);
    one.sz = spread(rays.sz, lane);
    all(rays.inverse, one.inverse);
    all(rays.origin, one.origin);
    one.shift = spread(rays.shift, lane);
    return one;
}

}  // namespace occam::accel
