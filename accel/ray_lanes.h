// Rays as the kernels see them: lanes that share their dominant axis and the signs of their direction.
//
// The watertight test (Woop et al. 2013) shears a ray onto its dominant axis. All per-ray constants are made by one function, so
// that a ray has the same bits alone, in a packet, and in the one-lane build.
//
// Space    directions: world. Origins: the dicing frame of one cage at a time (world axes, translated), see place().
#pragma once

#include <cmath>

#include "accel/tracer.h"
#include "scenegraph/base/simd.h"

namespace occam::accel {

/// Constants of one ray.
struct RayAxes {
    int kx, ky, kz;   ///< kz: the dominant axis; kx, ky: the next two, cyclic
    float sx, sy, sz; ///< shear and scale
    Vec3f inverse;    ///< 1 / direction, of components below kSmallest: of that size, with their sign
    bool negative[3];

    static constexpr float kSmallest = 1e-18f;

    explicit RayAxes(Vec3f d) noexcept
    {
        const Vec3f m = glm::abs(d);
        kz = m.x > m.y ? (m.x > m.z ? 0 : 2) : (m.y > m.z ? 1 : 2);
        kx = kz == 2 ? 0 : kz + 1;
        ky = kx == 2 ? 0 : kx + 1;
        sz = 1.0f / d[kz];
        sx = d[kx] * sz;
        sy = d[ky] * sz;
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
        return group() * 16 + quarter(sx) * 4 + quarter(sy);
    }
};

/// A ray's origin in a frame, moved along the ray to near the frame's own origin when it is far away: what is left is small,
/// so that floats hold it well. t of the ray = shift + t from that origin.
struct PlacedOrigin {
    Vec3f origin;
    float shift;
};
inline PlacedOrigin place(const Ray& ray, Vec3d anchor, float radius) noexcept
{
    constexpr double kNear = 4;  // radii: nearer than that the origin stays where it is
    const Vec3d from = ray.origin - anchor;
    const Vec3d d(ray.direction);
    const double along = -glm::dot(from, d);
    if (!(along > kNear * radius)) return {Vec3f(from), 0};
    const float shift = static_cast<float>(along);
    return {Vec3f(from + d * double(shift)), shift};
}

/// The constants of kLanes rays (or one ray in all lanes) and their origins in one cage's frame.
struct RayLanes {
    int kx, ky, kz;
    vfloat sx, sy, sz;
    vfloat inverse[3];
    vfloat origin[3];
    vfloat shift;
};

}  // namespace occam::accel
