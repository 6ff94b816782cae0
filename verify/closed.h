// Meshes as solids, in double: for tests of closedness.
#pragma once

#include <span>

#include "base/vec.h"

namespace occam {

/// Winding number of a closed mesh about a point (solid angles, Van Oosterom and Strackee 1983): 1 inside.
/// corners  three a triangle
double winding_number(std::span<const Vec3f> corners, Vec3d at);
double winding_number(std::span<const Vec3d> corners, Vec3d at);

}  // namespace occam
