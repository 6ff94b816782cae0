// Renumbering of the vertices of a cage: it chooses what faces use, and joins vertices of equal position.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::import {

/// Renumbers corners so that they count only those vertices that they use, in the same order, and returns these; none if all
/// are used. Corners that are not below the number of vertices become kNoIndex. The time depends on the number of corners
/// alone, up to a logarithm.
std::optional<std::vector<std::uint32_t>> choose_used_vertices(std::vector<std::uint32_t>& corners, std::size_t vertices);

/// Joins vertices of equal position. Texture coordinates and colours become face-varying, and each different value at
/// a vertex is kept once. Normals are dropped.
void weld_by_position(Cage& cage);

}  // namespace occam::import
