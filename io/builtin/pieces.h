// The things of the built-in still life. Each stands on y = 0 about the y axis; lengths are in decimetres or so.
#pragma once

#include <vector>

#include "scenegraph/cage.h"

namespace occam::builtin {

Cage vase();  ///< hollow, 3.1 high
Cage pawn();  ///< 1.5 high

/// Body, lid, spout (towards +x) and handle of a pot: cages that reach into each other. 1.7 high.
std::vector<Cage> teapot();

/// A trefoil knot about the y axis; its middle lies at the origin.
Cage knot();

/// One closed cage of each kind that the scene shows, for tests.
std::vector<Cage> closed_pieces();

}  // namespace occam::builtin
