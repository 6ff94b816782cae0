// Cross products of vectors in single precision whose squares may leave its range, such as the tangents of a cage that is a
// billionth of its scene, or the sides of a light that is 1e15 times as large.
#pragma once

#include "base/vec.h"

namespace occam {

/// Returns whether the square of a length is a normal number in single precision, with room on both sides.
inline bool has_square(float length) noexcept { return length > 1e-15f && length < 1e18f; }

/// Returns the unit vector along the cross product of two vectors, times `sense`; zero if they are parallel.
inline Vec3f unit_normal(Vec3f a, Vec3f b, float sense) noexcept
{
    const Vec3f n = glm::cross(a, b);
    if (const float length = glm::length(n); has_square(length)) [[likely]]
        return n * (sense / length);
    const Vec3d exact = glm::cross(Vec3d(a), Vec3d(b));
    const double length = glm::length(exact);
    return length > 0 ? Vec3f(exact * (double(sense) / length)) : Vec3f(0);
}

/// Returns the area of the parallelogram of two vectors.
inline float area_between(Vec3f a, Vec3f b) noexcept
{
    const float area = glm::length(glm::cross(a, b));
    return has_square(area) ? area : static_cast<float>(glm::length(glm::cross(Vec3d(a), Vec3d(b))));
}

}  // namespace occam
