// Holds rays as the kernels see them: lanes that share their dominant axis and the signs of their directions.
//
// The watertight test (Woop et al. 2013) shears a ray onto its dominant axis. One function computes all per-ray
// constants of a kind, so that a ray has the same bits alone, in a packet, and in the one-lane build.
//
// Space    Directions are in world space. Origins are in the dicing frame of one cage at a time (world axes,
//          translated), see place().
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "accel/ray.h"
#include "accel/vec_lanes.h"
#include "base/simd.h"
#include "lod/ray_levels.h"

namespace occam::accel {

/// Holds what rays must have in common to share a packet: the dominant axis and the octant.
struct RayAxes {
    int kx, ky, kz;  ///< kz is the dominant axis; kx and ky are the next two in cyclic order
    bool negative[3];

    static constexpr int kGroups = 3 * 8;

    RayAxes() = default;
    friend bool operator==(const RayAxes&, const RayAxes&) = default;
    /// group   is kz * 8 plus the signs of x, y and z, as the bits 1, 2 and 4.
    explicit RayAxes(int group) noexcept : kz(group / 8)
    {
        kx = kz == 2 ? 0 : kz + 1;
        ky = kx == 2 ? 0 : kx + 1;
        for (int a = 0; a < 3; ++a) negative[a] = (group >> a & 1) != 0;
    }
    /// Returns the group of a direction.
    static int group_of(const float (&direction)[3]) noexcept
    {
        const float x = std::fabs(direction[0]), y = std::fabs(direction[1]), z = std::fabs(direction[2]);
        int group = x > y && x > z ? 0 : y > z ? 8 : 16;
        for (int a = 0; a < 3; ++a) group += direction[a] < 0 ? 1 << a : 0;
        return group;
    }
};

/// Holds the shear of rays along their dominant axis: sx, sy, and the scale sz. F is vfloat, several of them, or float;
/// the bits are the same.
template <class F>
OCCAM_ALWAYS_INLINE void set_shear(const RayAxes& axes, const F* direction, F (&shear)[3]) noexcept
{
    shear[2] = F(1.0f) / direction[axes.kz];
    shear[0] = direction[axes.kx] * shear[2];
    shear[1] = direction[axes.ky] * shear[2];
}
inline constexpr float kLeastDirection = 1e-18f;  ///< the least component of a direction that is inverted
/// Computes 1 / direction. Components that are too small are replaced by the limit, with their sign.
template <class F>
OCCAM_ALWAYS_INLINE void set_inverse(const RayAxes& axes, const F* direction, F (&inverse)[3]) noexcept
{
    for (int a = 0; a < 3; ++a) {
        const F d = direction[a];
        inverse[a] = F(1.0f) /
                     select(abs(d) < F(kLeastDirection), F(axes.negative[a] ? -kLeastDirection : kLeastDirection), d);
    }
}

/// Holds a ray's origin in a frame. An origin that is far away is moved along the ray to near the frame's own origin:
/// the coordinates are then small and precise in floats. The ray's t is shift + t from that origin.
struct PlacedOrigin {
    float origin[3];
    float shift;
};
/// Returns how far along the ray the frame's own origin is, measured from an origin in that frame.
template <class F>
F shift_of(const F (&near)[3], const F* direction) noexcept
{
    return F(0.0f) - ((near[0] * direction[0] + near[1] * direction[1]) + near[2] * direction[2]);
}
inline constexpr float kNearRadii = 4;  ///< an origin nearer than this many radii of the frame is not moved

inline PlacedOrigin place(const Ray& ray, Vec3d anchor, float radius) noexcept
{
    const Vec3d from = ray.origin - anchor;
    const float near[3] = {float(from.x), float(from.y), float(from.z)},
                way[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    const float shift = shift_of(near, way);
    if (!(shift > kNearRadii * radius)) return {{near[0], near[1], near[2]}, 0};
    const Vec3f moved(from + Vec3d(ray.direction) * double(shift));
    return {{moved.x, moved.y, moved.z}, shift};
}

/// Does the same for a packet's rays: to[0] to to[2] receive origins, to[3] receives shifts. frame_of(i) gives the
/// anchor and the radius of the frame of ray i.
template <class F, class FrameOf>
OCCAM_ALWAYS_INLINE void place_all(std::span<const Ray> rays, const F* direction, FrameOf&& frame_of, F (&to)[4]) noexcept
{
    constexpr std::size_t kRays = sizeof(F) / sizeof(float);
    alignas(32) float near[3][kRays], radius[kRays], shift[kRays];
    for (std::size_t lane = 0; lane < kRays; ++lane) {
        const std::size_t i = std::min(lane, rays.size() - 1);
        const auto& frame = frame_of(i);
        const Vec3d from = rays[i].origin - frame.anchor;
        near[0][lane] = static_cast<float>(from.x);
        near[1][lane] = static_cast<float>(from.y);
        near[2][lane] = static_cast<float>(from.z);
        radius[lane] = frame.radius;
    }
    const F at[3] = {F::load(near[0]), F::load(near[1]), F::load(near[2])};
    const F along = shift_of(at, direction);
    const auto is_far = along > F(kNearRadii) * F::load(radius);
    if (none(is_far)) {
        for (int a = 0; a < 3; ++a) to[a] = at[a];
        to[3] = F(0.0f);
        return;
    }
    for (std::size_t lane = 0; lane < kRays; ++lane) {
        const std::size_t i = std::min(lane, rays.size() - 1);
        const auto& frame = frame_of(i);
        const PlacedOrigin placed = place(rays[i], frame.anchor, frame.radius);
        for (int a = 0; a < 3; ++a) near[a][lane] = placed.origin[a];
        shift[lane] = placed.shift;
    }
    for (int a = 0; a < 3; ++a) to[a] = F::load(near[a]);
    to[3] = F::load(shift);
}

inline float first_lane(vfloat x) noexcept { return hn::GetLane(x.raw()); }

/// Describes how rays blend the vertices of a frame: lod::Blend over the vertex's own distance along the ray, which is
/// d . v + k before it is clamped to [0, 1] (Djeu et al. 2011, sec. 5.2.6, with fine at the near end of a growing
/// footprint). F is as above, and the bits are the same.
template <class F>
struct VertexBlendOf {
    F d[3], k;

    /// Returns the blend for points that are given along three axes in this order.
    VertexBlendOf along(int kx, int ky, int kz) const noexcept { return {{d[kx], d[ky], d[kz]}, k}; }
    /// The origin and the shift are those of the rays in that frame.
    void set(const lod::Blend<F>& blend, const F (&direction)[3], const F (&origin)[3], F shift) noexcept
    {
        F along = shift - blend.start;
        for (int a = 0; a < 3; ++a) {
            along = fnma(direction[a], origin[a], along);
            d[a] = direction[a] * blend.scale;
        }
        k = along * blend.scale;
    }
    /// The weight is monotonic along each axis, rounding included: so the weights at the corners of a box bound those
    /// inside it.
    OCCAM_ALWAYS_INLINE F ramp(const VecOf<F>& v) const noexcept
    {
        return fma(v.x, d[0], fma(v.y, d[1], fma(v.z, d[2], k)));
    }

    /// The weight is 0 for fine and 1 for coarse.
    OCCAM_ALWAYS_INLINE F weight(const VecOf<F>& fine) const noexcept { return lod::coarse_weight(ramp(fine)); }
    /// Returns exactly `fine` and `coarse` at the ends, and where both are equal: the blend of a shared vertex has the
    /// same bits in all of its triangles and grids (watertightness rule 12).
    OCCAM_ALWAYS_INLINE VecOf<F> between(const VecOf<F>& fine, const VecOf<F>& coarse) const noexcept
    {
        return between(fine, coarse, weight(fine));
    }
    OCCAM_ALWAYS_INLINE static VecOf<F> between(const VecOf<F>& fine, const VecOf<F>& coarse, F w) noexcept
    {
        const auto at_end = w >= F(1.0f);
        const auto blend = [&](F f, F c) { return select(at_end, c, fma(w, c - f, f)); };
        return {blend(fine.x, coarse.x), blend(fine.y, coarse.y), blend(fine.z, coarse.z)};
    }
};
using VertexBlend = VertexBlendOf<vfloat>;

/// Holds the constants of kLanes rays (or of one ray in all lanes), and their origins and blend in one cage's frame.
struct RayLanes {
    int kx, ky, kz;
    vfloat sx, sy, sz;
    vfloat inverse[3];
    vfloat origin[3];
    vfloat shift;
    VertexBlend blend;
};

}  // namespace occam::accel
