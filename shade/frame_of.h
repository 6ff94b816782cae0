// An orthonormal frame about a direction, and maps from the unit square onto discs and hemispheres.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/maths.h"
#include "base/vec.h"

namespace occam::shade {

using maths::kPi;

/// Holds the axes x, y and z of a right-handed frame, where z is the given direction. The frame is continuous except at z
/// = -1 (Duff et al. 2017).
struct ShadingFrame {
    Vec3f x, y, z;

    explicit ShadingFrame(Vec3f unit) noexcept : z(unit)
    {
        const float sign = std::copysign(1.0f, unit.z);
        const float a = -1.0f / (sign + unit.z);
        const float b = unit.x * unit.y * a;
        x = {1 + sign * unit.x * unit.x * a, sign * b, -sign * unit.x};
        y = {b, sign + unit.y * unit.y * a, -unit.y};
    }
    Vec3f to_world(Vec3f v) const noexcept { return x * v.x + y * v.y + z * v.z; }
    Vec3f to_local(Vec3f v) const noexcept { return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)}; }
};

/// Returns a uniform point in the unit disc; the map keeps strata of the square compact (Shirley and Chiu 1997).
inline Vec2f disc_point(Vec2f square) noexcept
{
    const Vec2f p = square * 2.0f - 1.0f;
    if (p.x == 0 && p.y == 0) return {0, 0};
    const bool wide = std::fabs(p.x) > std::fabs(p.y);
    const float radius = wide ? p.x : p.y;
    const float angle = wide ? kPi / 4 * (p.y / p.x) : kPi / 2 - kPi / 4 * (p.x / p.y);
    const maths::SinCos at = maths::sin_cos(angle);
    return {radius * at.cos, radius * at.sin};
}

/// Returns a direction about +z with density cos / pi.
inline Vec3f cosine_direction(Vec2f square) noexcept
{
    const Vec2f d = disc_point(square);
    return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

/// The density of directions that are spread evenly over a hemisphere.
inline constexpr float kHemisphereDensity = 1 / (2 * kPi);

/// Returns a direction of the upper hemisphere, of even density, in axes whose z is the normal.
inline Vec3f hemisphere_direction(Vec2f square) noexcept
{
    const float z = 1 - square.x, radius = std::sqrt(std::max(0.0f, 1 - z * z)), angle = 2 * kPi * square.y;
    return {radius * maths::cos(angle), radius * maths::sin(angle), z};
}

}  // namespace occam::shade
