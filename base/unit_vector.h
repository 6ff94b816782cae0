// Unit vectors of directions that a person or an application gives, of whatever length.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"

namespace occam {

/// Returns the unit vector of a direction, and zero for one that is zero or not finite. Squares of the lengths of others may
/// be too large or too small for a double.
inline Vec3d unit_vector(Vec3d direction) noexcept
{
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
        if (!std::isfinite(direction[c])) return Vec3d(0);
        largest = std::max(largest, std::abs(direction[c]));
    }
    if (largest == 0) return Vec3d(0);
    for (int c = 0; c < 3; ++c) direction[c] = std::scalbn(direction[c], -std::ilogb(largest));
    return direction / glm::length(direction);
}

}  // namespace occam
