// Rays as the kernels see them: lanes that share their dominant axis and the signs of their direction.
//
// The watertight test (Woop et al. 2013) shears a ray onto its dominant axis. All per-ray constants are made by one function, so
// that a ray has the same bits alone, in a packet, and in the one-lane build.
//
// Space    directions: world. Origins: the dicing frame of one cage at a time (world axes, translated), see place().
#pragma once

#include <cmath>

#include "accel/tracer.h"
#include "accel/vec_lanes.h"
#include "lod/ray_levels.h"
#include "scenegraph/base/simd.h"

namespace occam::accel {

/// Constants of one ray.
struct RayAxes {
    float shear[4];    ///< sx, sy, and the scale sz; the fourth is to spare, so that four are loaded at a time
    float inverse[4];  ///< 1 / direction, of components below kSmallest: of that size, with their sign; the same
    int kx, ky, kz;    ///< kz: the dominant axis; kx, ky: the next two, cyclic
    bool negative[3];

    static constexpr float kSmallest = 1e-18f;

    explicit RayAxes(Vec3f d) noexcept
    {
        const Vec3f m = glm::abs(d);
        kz = m.x > m.y ? (m.x > m.z ? 0 : 2) : (m.y > m.z ? 1 : 2);
        kx = kz == 2 ? 0 : kz + 1;
        ky = kx == 2 ? 0 : kx + 1;
        const float sz = 1.0f / d[kz];
        shear[0] = d[kx] * sz;
        shear[1] = d[ky] * sz;
        shear[2] = sz;
        shear[3] = inverse[3] = 0;
        for (int a = 0; a < 3; ++a) {
            negative[a] = std::signbit(d[a]);
            inverse[a] = 1.0f / (m[a] < kSmallest ? std::copysign(kSmallest, d[a]) : d[a]);
        }
    }
    /// Rays with equal octants and axes may share a packet.
    int group() const noexcept { return kz * 8 + negative[0] + 2 * negative[1] + 4 * negative[2]; }
    /// A group has sixteen bins of like directions.
    static constexpr int kBins = 24 * 16;
    int bin() const noexcept
    {
        const auto quarter = [](float s) { return (s > -0.5f) + (s > 0) + (s > 0.5f); };
        return group() * 16 + quarter(shear[0]) * 4 + quarter(shear[1]);
    }
};

/// A ray's origin in a frame, moved along the ray to near the frame's own origin when it is far away: what is left is small,
/// so that floats hold it well. t of the ray = shift + t from that origin.
struct PlacedOrigin {
    float origin[3];
    float shift;
};
inline PlacedOrigin place(const Ray& ray, Vec3d anchor, float radius) noexcept
{
    constexpr float kNear = 4;  // radii: nearer than that the origin stays where it is
    const Vec3d from = ray.origin - anchor;
    const Vec3f near(from);
    const float shift = -glm::dot(near, ray.direction);
    if (!(shift > kNear * radius)) return {{near.x, near.y, near.z}, 0};
    const Vec3f moved(from + Vec3d(ray.direction) * double(shift));
    return {{moved.x, moved.y, moved.z}, shift};
}

inline float first_lane(vfloat x) noexcept
{
    float lanes[kLanes];
    x.store(lanes);
    return lanes[0];
}

/// How rays blend the vertices of a frame: lod::Blend over the vertex's own distance along the ray, d . v + k before it is cut off
/// at 0 and 1 (Djeu et al. 2011, sec. 5.2.6, with fine at the near end of a growing footprint). F as above: the same bits.
template <class F>
struct VertexBlendOf {
    F d[3], k;

    /// The same of points given along three axes in this order.
    VertexBlendOf along(int kx, int ky, int kz) const noexcept { return {{d[kx], d[ky], d[kz]}, k}; }
    /// origin, shift: of the rays in that frame.
    void set(const lod::Blend<F>& blend, const F (&direction)[3], const F (&origin)[3], F shift) noexcept
    {
        F along = shift - blend.start;
        for (int a = 0; a < 3; ++a) {
            along = fnma(direction[a], origin[a], along);
            d[a] = direction[a] * blend.scale;
        }
        k = along * blend.scale;
    }
    /// Rises or falls along each axis without a step back, rounding included: so the corners of a box bound what is in it.
    OCCAM_ALWAYS_INLINE F ramp(const VecOf<F>& v) const noexcept { return fma(v.x, d[0], fma(v.y, d[1], fma(v.z, d[2], k))); }

    /// 0: fine, 1: coarse.
    OCCAM_ALWAYS_INLINE F weight(const VecOf<F>& fine) const noexcept
    {
        const F x = min(max(ramp(fine), F(0.0f)), F(1.0f));
        return x * x * (F(3.0f) - (x + x));
    }
    /// Exactly `fine` and `coarse` at the ends, and where both are the same: the blend of a shared vertex has the same bits in all
    /// of its triangles and grids (watertightness rule 7).
    OCCAM_ALWAYS_INLINE VecOf<F> between(const VecOf<F>& fine, const VecOf<F>& coarse) const noexcept { return between(fine, coarse, weight(fine)); }
    OCCAM_ALWAYS_INLINE static VecOf<F> between(const VecOf<F>& fine, const VecOf<F>& coarse, F w) noexcept
    {
        const auto at_end = w >= F(1.0f);
        const auto blend = [&](F f, F c) { return select(at_end, c, fma(w, c - f, f)); };
        return {blend(fine.x, coarse.x), blend(fine.y, coarse.y), blend(fine.z, coarse.z)};
    }
};
using VertexBlend = VertexBlendOf<vfloat>;

/// The constants of kLanes rays (or one ray in all lanes), and their origins and blend in one cage's frame.
struct RayLanes {
    int kx, ky, kz;
    vfloat sx, sy, sz;
    vfloat inverse[3];
    vfloat origin[3];
    vfloat shift;
    VertexBlend blend;
};

}  // namespace occam::accel
