// The parts of a cage that are too large for tables of weights: polygons of very many corners, and vertices of very many
// faces. Each pose of a cage that has one keeps derived points (lod/derived_points.h), in memory that a budget must have.
#pragma once

#include <cstddef>

#include "scenegraph/cage.h"

namespace occam {

/// Faces of at least so many corners, and vertices of at least so many faces, are large.
inline constexpr std::size_t kLargeFrom = 65;
/// A face whose patches would depend on more vertices takes derived points, too: some hundreds of them stand for what is
/// around the corners of one quad of the refined cage.
inline constexpr std::size_t kMostControls = 1024;
/// The number of moves of a large vertex, which are derived points of its own. Each is at most 0.66 times as long as the one
/// before, so the rest is at most a ten-thousandth of the first one.
inline constexpr std::size_t kMovesOfALargeVertex = 24;
/// The least room that OpenSubdiv 3.5 has for the whole numbers and for the sharpnesses of what surrounds a face, which it
/// may exceed if there are creases (lod/unsafe_faces.h).
inline constexpr std::size_t kLeastInts = 256, kLeastFloats = 64;

/// Returns a number that the derived points of a pose of a sanitized cage do not exceed; 0 if there are none.
std::size_t most_derived_points(const Cage& cage);

}  // namespace occam
