// Builds the surface that one ray sees, as a mesh: between two transitions it is the mesh of that pair of levels, with
// each vertex blended for the ray.
#pragma once

#include <functional>
#include <vector>

#include "lod/level_grid.h"
#include "lod/ray_levels.h"

namespace occam {

/// Returns how often the surface that a ray sees winds around a point, in double and without any tree.
///
/// The ray's pairs are cut at its transitions, the planes at distance t along it, and the solid angles of the pieces
/// are summed. Pairs finer than `finest` are replaced by `finest`: pieces that small change nothing.
///
/// from    is the origin of the ray, in the frame of the grids.
/// table   is the ray's table, already made.
/// dice    returns all grids of a cage for the pair of a level and the next one.
double winding_number_of_ray(Vec3d point, Vec3d from, Vec3d direction, const lod::RayLevels<float>& table, int finest,
                             const std::function<const std::vector<lod::LevelGrid>&(int level)>& dice);

}  // namespace occam
