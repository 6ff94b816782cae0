// The parts of a cage that are too large for tables of weights: polygons of very many corners, and vertices of very many
// faces. Each pose of a cage that has one keeps derived points (lod/derived_points.h), in memory that a budget must have.
#pragma once

#include <cstddef>

#include "scenegraph/cage.h"

namespace occam {

/// Faces of as many corners, and vertices of as many faces, are large.
inline constexpr std::size_t kLargeFrom = 65;
/// A face whose patches would depend on more vertices takes derived points, too: some hundreds of them stand for what is
/// around the corners of one quad of the refined cage.
inline constexpr std::size_t kMostControls = 1024;
/// How many derived points a large vertex has of its own: each is at most 0.66 times as far from the one before as that one
/// is, so the rest is at most a ten-thousandth of the first distance.
inline constexpr std::size_t kMovesOfALargeVertex = 24;

/// Returns a number that the derived points of a pose of a sanitized cage do not exceed; 0 if there are none.
std::size_t most_derived_points(const Cage& cage);

}  // namespace occam
