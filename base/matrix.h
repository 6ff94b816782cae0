// What a linear map does to the orientation of space.
#pragma once

#include "base/vec.h"

namespace occam {

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
