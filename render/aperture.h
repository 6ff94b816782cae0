// The opening of a lens: a disc, or a regular polygon of blades.
#pragma once

#include <algorithm>

#include "shade/frame_of.h"

namespace occam::render {

/// Returns a uniform point in the opening, whose corners (or rim) lie at distance 1. `square` is uniform in [0, 1). With
/// fewer than 3 blades the opening is a disc.
inline Vec2f aperture_point(Vec2f square, int blades) noexcept
{
    if (blades < 3) return shade::disc_point(square);
    // This picks one of the triangles about the middle, and a point in it. Its base is the edge between two corners.
    const float at = square.x * static_cast<float>(blades);
    const float blade = std::min(std::floor(at), static_cast<float>(blades - 1));
    const float along = at - blade, out = std::sqrt(square.y);
    const float turn = 2 * shade::kPi / static_cast<float>(blades);
    const auto corner = [&](float number) { return Vec2f(maths::cos(turn * number), maths::sin(turn * number)); };
    return out * ((1 - along) * corner(blade) + along * corner(blade + 1));
}

}  // namespace occam::render
