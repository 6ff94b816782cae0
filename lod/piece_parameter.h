// The parameter of a piece of a patch.
#pragma once

#include "base/power_of_two.h"

namespace occam::lod {

/// Returns the parameter of a piece that begins at t0 and has the size 1 / 2^depth. It is exact because all are dyadic.
inline double local(float t, float t0, int depth) noexcept { return (double(t) - double(t0)) * power_of_two_double(depth); }

}  // namespace occam::lod
