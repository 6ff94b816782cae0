// Cross products of vectors that may be so short that the squares of their products vanish in single precision, as those of
// the tangents of a cage that is a billionth of its scene.
#pragma once

#include "base/vec.h"

namespace occam::lod {

/// The length of a cross product from which on single precision serves.
inline constexpr float kLongCross = 1e-15f;

/// Returns the unit vector along the cross product of two vectors, times `sense`; zero if they are parallel.
inline Vec3f unit_normal(Vec3f a, Vec3f b, float sense) noexcept
{
    const Vec3f n = glm::cross(a, b);
    if (const float length = glm::length(n); length > kLongCross) [[likely]]
        return n * (sense / length);
    const Vec3d exact = glm::cross(Vec3d(a), Vec3d(b));
    const double length = glm::length(exact);
    return length > 0 ? Vec3f(exact * (double(sense) / length)) : Vec3f(0);
}

/// Returns the area of the parallelogram of two vectors.
inline float area_between(Vec3f a, Vec3f b) noexcept
{
    const float area = glm::length(glm::cross(a, b));
    return area > kLongCross ? area : static_cast<float>(glm::length(glm::cross(Vec3d(a), Vec3d(b))));
}

}  // namespace occam::lod
