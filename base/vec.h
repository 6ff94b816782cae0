// The vector types of every room: GLM's types under the names that the rest of the code uses.
//
// The suffix names the element type: f is float, d is double, i is int. Points are double where they may lie far from the
// origin (world axes) and float in a frame near the geometry (see lod/posed_cage.h).
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace occam {

using Vec2f = glm::vec2;
using Vec3f = glm::vec3;
using Vec4f = glm::vec4;
using Vec2d = glm::dvec2;
using Vec3d = glm::dvec3;
using Vec4d = glm::dvec4;
using Mat3d = glm::dmat3;
using Mat4d = glm::dmat4;

/// Returns M p, the image of a point; the last row of `m` is not read (affine).
inline Vec3d transform_point(const Mat4d& m, Vec3d p) noexcept
{
    return Vec3d(m[0]) * p.x + Vec3d(m[1]) * p.y + Vec3d(m[2]) * p.z + Vec3d(m[3]);
}

/// Returns M v, the image of a direction (no translation).
inline Vec3d transform_vector(const Mat4d& m, Vec3d v) noexcept
{
    return Vec3d(m[0]) * v.x + Vec3d(m[1]) * v.y + Vec3d(m[2]) * v.z;
}

}  // namespace occam
