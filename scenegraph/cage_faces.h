// Visits the faces of cages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "scenegraph/cage.h"

namespace occam {

/// Returns a number that is the same for both directions of an edge, and for no other edge.
inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) noexcept
{
    return std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
}

/// Calls visit(face, first) with the vertices of each face of a cage that is not a mesh of triangles; `first` is the number
/// of its first corner.
template <class Visit>
void for_each_face(const Cage& cage, Visit&& visit)
{
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        visit(std::span<const std::uint32_t>(cage.face_vertices).subspan(first, size), first);
        first += size;
    }
}

/// Returns the area of a polygon: half the length of the sum of its corners' cross products.
/// at   returns the place of a corner by its number
template <class At>
double polygon_area(std::size_t corners, At&& at) noexcept
{
    const Vec3d origin = at(0);
    Vec3d sum(0), before = at(1) - origin;
    for (std::size_t corner = 2; corner < corners; ++corner) {
        const Vec3d next = at(corner) - origin;
        sum += glm::cross(before, next);
        before = next;
    }
    return 0.5 * glm::length(sum);
}

}  // namespace occam
