// Removal of triangles that lie in one place.
#pragma once

#include "io/import/report.h"
#include "scenegraph/cage.h"

namespace occam::import {

/// Keeps the first of several triangles of a mesh that have the same corners and the same direction of rotation, whatever
/// their materials are: a ray would have to test all of them, and can show only one. Looks for them only where the boxes of
/// the triangles overlap so much that many may lie in one place. Corners are the same if their positions are, or, in a mesh
/// that a skin or morph targets deform, if they are the same vertex. Reports how many were dropped.
void drop_same_triangles(Cage& cage, Report& report);

}  // namespace occam::import
