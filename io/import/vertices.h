// Renumbering of the vertices of a cage: it leaves out what no face uses, and joins vertices of equal position.
#pragma once

#include "scenegraph/cage.h"

namespace occam::import {

/// Removes vertices that no face refers to.
void drop_unused_vertices(Cage& cage);

/// Joins vertices of equal position. Texture coordinates and colours become face-varying, and each different value at
/// a vertex is kept once. Normals are dropped.
void weld_by_position(Cage& cage);

}  // namespace occam::import
