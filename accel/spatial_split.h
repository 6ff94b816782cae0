// Splits triangles at a plane in space, so that those on both sides are referred to twice, by the box of a part each (Stich
// et al. 2009, and under motion Grünschloß et al. 2011).
//
// This serves triangles whose boxes overlap however they are distributed: long, slanted ones, and large ones among small
// ones.
//
// Threads  one at a time.
#pragma once

#include <span>
#include <vector>

#include "base/box.h"
#include "lod/face_split.h"

namespace occam::accel {

/// Refers to the triangles of an igrid.
struct TriangleCorners {
    std::span<const Vec3f> middle;   ///< three corners each at mid-shutter, where they are split
    std::span<const Vec3f> at_keys;  ///< the same at each key, one key after the other
    const Vec3f* of(std::uint32_t face) const noexcept { return &middle[std::size_t(face) * 3]; }
};

/// The two sides of a split.
struct SpatialParts {
    std::vector<lod::BoxedFace> below, above;
};

/// Splits some triangles, or parts of these, if rays then test fewer blocks. Returns whether it has; `to` then has all of
/// them, with at most `spare` more than there were.
/// below_cost   the cost that a split has to be less than, as areas of boxes times numbers of blocks
bool split_in_space(std::span<const lod::BoxedFace> parts, const TriangleCorners& corners, float below_cost,
                    std::size_t spare, SpatialParts& to);

/// Returns the number of blocks that hold so many triangles.
constexpr float blocks_of(std::size_t triangles) noexcept
{
    return static_cast<float>((triangles + lod::kFacesOfABlock - 1) / lod::kFacesOfABlock);
}

}  // namespace occam::accel
