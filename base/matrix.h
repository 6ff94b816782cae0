// What a linear map does to lengths and to the orientation of space.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/vec.h"

namespace occam {

/// Returns a bound of how many times as long a linear map makes a vector; it is exact where the images of the axes are at
/// right angles.
inline double largest_stretch(const Mat3d& map) noexcept
{
    // The largest eigenvalue of the map's Gram matrix is at most its largest row sum.
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
        double row = 0;
        for (int b = 0; b < 3; ++b) row += std::abs(glm::dot(map[a], map[b]));
        largest = std::max(largest, row);
    }
    return std::sqrt(largest);
}

/// Returns the determinant of a map whose columns are made unit vectors: 1 or -1 where they are at right angles, and near 0
/// where the map flattens space to a plane or a line.
inline double evenness(const Mat3d& map) noexcept
{
    Mat3d columns;
    for (int c = 0; c < 3; ++c) {
        const double length = glm::length(map[c]);
        if (!(length > 0)) return 0;
        columns[c] = map[c] / length;
    }
    return glm::determinant(columns);
}
/// The sign of the determinant of a map that is no more even than this is that of a rounding error.
inline constexpr double kFlattest = 0x1p-40;
/// Returns whether a map flattens space.
inline bool flattens(const Mat3d& map) noexcept { return !(glm::abs(evenness(map)) > kFlattest); }
/// Returns whether a map reverses the orientation of faces. One that flattens space does not.
inline bool mirrors(const Mat3d& map) noexcept
{
    return glm::determinant(map) < 0 && evenness(map) < -kFlattest;  // most maps need no square roots
}

}  // namespace occam
