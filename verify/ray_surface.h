// The surface that one ray sees, as a mesh: between two transitions the mesh of that pair of levels, each vertex blended for
// the ray.
#pragma once

#include <functional>
#include <vector>

#include "lod/level_grid.h"
#include "lod/ray_levels.h"

namespace occam {

/// Winding number of the surface that a ray sees about the ray's own origin, in double and without any tree.
///
/// The ray's pairs are cut at its transitions, the planes at distance t along it, and the solid angles of the pieces are
/// summed. What lies on pairs finer than `finest` is taken from `finest`: pieces that small change nothing.
///
/// table   of the ray, made
/// dice    gives all grids of a cage for the pair of a level and the next
double winding_number_of_ray(Vec3d from, Vec3d direction, const lod::RayLevels<float>& table, int finest,
                             const std::function<const std::vector<lod::LevelGrid>&(int level)>& dice);

}  // namespace occam
