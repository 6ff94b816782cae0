// Renumbering the vertices of a cage: leaving out what no face uses, and joining what lies at one place.
#pragma once

#include "scenegraph/cage.h"

namespace occam::import {

/// Takes out vertices that no face refers to.
void drop_unused_vertices(Cage& cage);

/// Joins vertices of equal position. Texture coordinates become face-varying: one value for each different (vertex, uv).
/// Normals are dropped.
void weld_by_position(Cage& cage);

}  // namespace occam::import
