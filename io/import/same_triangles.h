// Removal of triangles that lie in one place, and refusal of meshes whose triangles overlap too much.
#pragma once

#include "io/import/report.h"
#include "scenegraph/cage.h"

namespace occam::import {

/// Keeps the first of several triangles of a mesh that have the same corners and the same direction of rotation, whatever
/// their materials are: a ray would have to test all of them, and can show only one. Looks for them only where the boxes of
/// the triangles overlap so much that many may lie in one place. Corners are the same if
/// their vertices have one place in every pose (places_of()). Reports how many were dropped.
void drop_same_triangles(Cage& cage, Report& report);

/// Throws Error for a mesh in which a ray would pass the boxes of more than kMostBoxes triangles, as in hundreds of
/// thousands of large triangles at random: a picture of it would take minutes.
void check_boxes(const Cage& cage, const Report& report);
inline constexpr double kMostBoxes = 1 << 17;

}  // namespace occam::import
