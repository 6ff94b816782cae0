// A Morton curve through a box: points that are near each other are mostly near each other along it, too.
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/box.h"

namespace occam {

/// Spreads the lowest 21 bits so that two zeros follow each of them.
constexpr std::uint64_t spread_bits(std::uint64_t x) noexcept
{
    x = (x | x << 32) & 0x001f00000000ffffull;
    x = (x | x << 16) & 0x001f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

/// Returns the place of a point along the curve through the box, whose sides have 2^21 - 1 steps. A coordinate that is not a
/// number counts as the least one.
inline std::uint64_t morton_code(Vec3d p, const Box3d& within) noexcept
{
    constexpr double kSteps = 2097151;
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double share = (p[axis] - within.lo[axis]) / (within.hi[axis] - within.lo[axis]);
        const double step = share > 0 ? std::min(share, 1.0) * kSteps : 0;  // 0 where the box is flat, too
        code |= spread_bits(static_cast<std::uint64_t>(step)) << axis;
    }
    return code;
}

}  // namespace occam
