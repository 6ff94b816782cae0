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
/// Returns whether a map flattens space. The sign of its determinant is then that of a rounding error.
inline bool flattens(const Mat3d& map) noexcept
{
    constexpr double kFlattest = 0x1p-40;
    const double even = evenness(map);
    return !(even > kFlattest || even < -kFlattest);
}
/// Returns whether a map reverses the orientation of faces. One that flattens space does not.
inline bool mirrors(const Mat3d& map) noexcept { return evenness(map) < 0 && !flattens(map); }

}  // namespace occam
