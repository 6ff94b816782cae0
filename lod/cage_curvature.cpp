#include "lod/cage_curvature.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "scenegraph/cage_faces.h"

namespace occam::lod {

double least_radius_of_curvature(const Cage& cage)
{
    // The limit surface of a square has two thirds of the radius of its control points, and bends more than other sections.
    constexpr double kLimit = 2.0 / 3;
    std::vector<Vec3d> normals(cage.positions.size(), Vec3d(0));
    const auto position = [&](std::uint32_t v) { return Vec3d(cage.positions[v]); };
    for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t) {
        Vec3d area(0);
        for (std::size_t c = 2; c < face.size(); ++c)
            area += glm::cross(position(face[c - 1]) - position(face[0]), position(face[c]) - position(face[0]));
        for (const std::uint32_t v : face) normals[v] += area;
    });
    for (Vec3d& normal : normals)
        if (const double length = glm::length(normal); length > 0) normal /= length;
    // Where the surface bends to and fro from vertex to vertex, the normals of vertices may all be the same. Those of the
    // faces' corners are not.
    double curvature = 0;
    for_each_face(cage, [&](std::span<const std::uint32_t> face, std::size_t) {
        for (std::size_t c = 0; c < face.size(); ++c) {
            const std::uint32_t at = face[c], next = face[c + 1 < face.size() ? c + 1 : 0],
                                last = face[c > 0 ? c - 1 : face.size() - 1];
            const Vec3d to_next = position(next) - position(at), to_last = position(last) - position(at);
            if (const double length = glm::length(to_next); length > 0)
                curvature = std::max(curvature, glm::distance(normals[next], normals[at]) / length);
            const Vec3d across = glm::cross(to_next, to_last);
            const double area = glm::length(across);
            if (!(area > 0)) continue;
            const Vec3d tilt = across / area - normals[at];  // over half of an edge
            for (const Vec3d edge : {to_next, to_last})
                curvature = std::max(curvature, 2 * std::abs(glm::dot(tilt, edge)) / glm::dot(edge, edge));
        }
    });
    return curvature > 0 ? kLimit / curvature : std::numeric_limits<double>::infinity();
}

}  // namespace occam::lod
