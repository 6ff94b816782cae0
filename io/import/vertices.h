// Renumbering of the vertices of a cage: it chooses what faces use, and joins vertices that are one.
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

/// The place of each vertex, by number.
struct VertexPlaces {
    std::vector<std::uint32_t> of;
    std::size_t count = 0;
};

/// Returns the places of the vertices of a cage. Vertices of one place are so in every pose: they have equal positions, and
/// morph targets and joints move them alike.
VertexPlaces places_of(const Cage& cage);

/// Joins vertices of equal position that morph targets and skins move alike, so that lips which are closed at rest can open.
/// Texture coordinates and colours become face-varying, and each different value at a vertex is kept once. Normals are
/// dropped, and so are what morph targets add to them.
void weld(Cage& cage);

}  // namespace occam::import
