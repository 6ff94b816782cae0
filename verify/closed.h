// Treats meshes as solids, in double precision, for tests of closedness.
#pragma once

#include <span>

#include "base/vec.h"

namespace occam {

/// Returns the winding number of a closed mesh about a point (by solid angles, Van Oosterom and Strackee 1983); it is 1
/// inside.
/// corners  three per triangle
double winding_number(std::span<const Vec3f> corners, Vec3d at);
double winding_number(std::span<const Vec3d> corners, Vec3d at);

}  // namespace occam
