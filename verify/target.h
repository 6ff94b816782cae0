// Chooses points of a diced mesh at which rays are aimed: the places where two triangles meet.
//
// Space    world axes, from the anchor of the cage at its moment (Subject::anchor_at).
#pragma once

#include <random>

#include "lod/ray_levels.h"
#include "verify/subject.h"

namespace occam {

using Random = std::mt19937_64;
inline double uniform(Random& random) { return double(random() >> 11) * 0x1p-53; }
inline double uniform(Random& random, double low, double high) { return low + (high - low) * uniform(random); }
template <class List>
const auto& pick(const List& list, Random& random)
{
    return list[random() % list.size()];
}

inline Vec3d any_direction(Random& random)
{
    while (true) {
        const Vec3d d{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
        if (const double l = glm::length(d); l > 0.1 && l <= 1) return d / l;
    }
}

/// Describes a point of the mesh as a function of a ray's blend.
struct Target {
    const lod::LevelGrid* grid = nullptr;
    int a = 0, c = 0;  ///< vertices; a point between them, or the T-vertex
    const lod::Hanging* hanging = nullptr;
    double share = 0;  ///< the share of c, unless the point is a T-vertex

    Vec3d at(Vec3d from, Vec3d direction, const lod::Blend<float>& blend) const
    {
        const auto blended = [&](int vertex) {
            const Vec3f fine = grid->at(vertex), coarse = grid->coarse_at(vertex);
            const float w = blend.weight(static_cast<float>(glm::dot(Vec3d(fine) - from, direction)));
            return fine + (coarse - fine) * w;
        };
        if (hanging) return Vec3d(hanging->on(blended(a), blended(c)).middle);
        return glm::mix(Vec3d(blended(a)), Vec3d(blended(c)), share);
    }
};

/// Picks a target: 30 % are T-vertices (if there are any), 15 % are vertices, and the others are points of edges and
/// diagonals.
/// grids     to pick from
/// hanging   those of them that have T-vertices
inline Target any_target(std::span<const lod::LevelGrid> grids, std::span<const lod::LevelGrid> hanging, Random& random)
{
    Target target;
    const double choice = uniform(random);
    if (choice < 0.3 && !hanging.empty()) {
        target.grid = &pick(hanging, random);
        target.hanging = &pick(target.grid->hanging, random);
        target.a = static_cast<int>(target.hanging->a);
        target.c = static_cast<int>(target.hanging->c);
        return target;
    }
    target.grid = &pick(grids, random);
    const int i = static_cast<int>(random() % static_cast<unsigned>(target.grid->tile.columns));
    const int j = static_cast<int>(random() % static_cast<unsigned>(target.grid->tile.rows));
    const int to[3][2] = {{1, 0}, {0, 1}, {1, 1}};
    const int* step = to[random() % 3];
    target.a = target.grid->index(i, j);
    target.c = target.grid->index(i + step[0], j + step[1]);
    target.share = choice < 0.45 ? 0 : uniform(random);
    return target;
}

}  // namespace occam
