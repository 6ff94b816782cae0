// Dense cages made by refining coarse ones, and cages of quads and triangles mixed: what modelling programs write.
#pragma once

#include "scenegraph/cage.h"

namespace occam::test {

/// Returns the cage after one step of refinement, which gives quads only.
/// is_smooth   vertices move by the rules of Catmull and Clark; otherwise new ones lie in the middle of edges and faces
Cage refined(const Cage& cage, bool is_smooth);

/// Returns a closed cage in which every second quad or so is cut in two along one of its diagonals.
Cage with_triangles(const Cage& cage, std::uint32_t seed);

}  // namespace occam::test
