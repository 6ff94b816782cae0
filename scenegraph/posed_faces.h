// Measures a posed cage by its faces, or by some of them where all would take too long.
//
// Threads  any number.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "scenegraph/cage.h"

namespace occam {

/// The vertices of a face.
using FaceVertices = std::span<const std::uint32_t>;

/// Returns every step-th face of a cage.
inline std::vector<FaceVertices> faces_of(const Cage& cage, std::size_t step = 1)
{
    const FaceVertices vertices(cage.face_vertices);
    const std::size_t count = cage.face_count();
    std::vector<FaceVertices> faces;
    std::size_t first = 0;
    for (std::size_t face = 0; face < count; ++face) {
        const std::size_t size = cage.scheme == Scheme::Triangles ? 3 : cage.face_sizes[face];
        if (face % step == 0) faces.push_back(vertices.subspan(first, size));
        first += size;
    }
    return faces;
}
/// Returns at most kSomeFaces faces, evenly spaced in their order. It visits all of them.
inline constexpr std::size_t kSomeFaces = 128;
inline std::vector<FaceVertices> some_faces(const Cage& cage)
{
    return faces_of(cage, std::max<std::size_t>(1, (cage.face_count() + kSomeFaces - 1) / kSomeFaces));
}

/// How far the normal of a face between two keys of a motion may be from that of the surface, in radians. Interpolated
/// normals are off where vertices move against each other, even along straight lines.
inline constexpr double kMostTurn = 0.05;
/// Returns whether a normal that is interpolated between keys is near enough to that which the face has then, which is 0 if
/// it has none.
inline bool is_near_normal(Vec3d interpolated, Vec3d normal) noexcept
{
    return normal == Vec3d(0) || glm::dot(interpolated, normal) >= std::cos(kMostTurn) * glm::length(interpolated);
}

/// Returns a vertex as morph targets move it.
/// positions   at rest
inline Vec3d morphed(const Cage& cage, std::span<const Vec3f> positions, std::span<const float> weights,
                     std::uint32_t v) noexcept
{
    Vec3d p(positions[v]);
    for (std::size_t k = 0; k < std::min(weights.size(), cage.morph_targets.size()); ++k)
        if (weights[k] != 0 && !cage.morph_targets[k].positions.empty())
            p += Vec3d(cage.morph_targets[k].positions[v]) * double(weights[k]);
    return p;
}

/// Returns the vector area of a face, which is twice its area long and points outside.
/// position_of   returns the position of a vertex, as a Vec3d
template <class PositionOf>
Vec3d vector_area(FaceVertices face, PositionOf&& position_of)
{
    const Vec3d from = position_of(face[0]);
    Vec3d area(0), last = position_of(face[1]) - from;
    for (std::size_t k = 2; k < face.size(); ++k) {
        const Vec3d next = position_of(face[k]) - from;
        area += glm::cross(last, next);
        last = next;
    }
    return area;
}

/// Returns the unit normal of a face, which points outside; 0 if it has no area.
template <class PositionOf>
Vec3d face_normal(FaceVertices face, PositionOf&& position_of)
{
    const Vec3d area = vector_area(face, position_of);
    const double length = glm::length(area);
    return length > 0 ? area / length : Vec3d(0);
}

}  // namespace occam
