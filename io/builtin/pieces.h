// The objects of the built-in still life. Each but the knot stands on y = 0 about the y axis; lengths are roughly in
// decimetres.
#pragma once

#include <vector>

#include "scenegraph/cage.h"

namespace occam::builtin {

Cage vase();  ///< hollow, 3.1 high
Cage pawn();  ///< 1.5 high

/// Returns the body, lid, spout (towards +x) and handle of a pot, as cages that reach into each other. The pot is 1.7 high.
std::vector<Cage> teapot();

/// Returns a trefoil knot about the y axis, with its middle at the origin.
Cage knot();

/// Returns one closed cage of each kind that the scene shows, for tests.
std::vector<Cage> closed_pieces();

}  // namespace occam::builtin
