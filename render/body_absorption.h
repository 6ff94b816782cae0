// How much light a body leaves over a length of the way through it (Beer-Lambert).
#pragma once

#include <algorithm>
#include <limits>

#include "accel/ray.h"
#include "base/maths.h"
#include "base/vec.h"
#include "scenegraph/frame_scale.h"

namespace occam::render {

/// Returns t of the surface behind which a ray starts: t_near lies a little farther (accel::behind()), and the differences
/// would add up where a ray passes many surfaces.
inline float start_of(const accel::Ray& ray) noexcept
{
    return ray.t_near * (1 - 4 * std::numeric_limits<float>::epsilon());
}

/// Returns the share that is left, in each channel. Light from infinitely far is not dimmed: no boundary of a body lies on
/// its way.
/// absorption   coefficient per world length
/// length       in frame lengths
inline Vec3f left_by_body(Vec3f absorption, float length, const FrameScale& scale) noexcept
{
    Vec3f left(1);
    if (absorption == Vec3f(0) || !(length < std::numeric_limits<float>::infinity())) return left;
    const float in_world = std::min(scale.to_world(length), std::numeric_limits<float>::max());
    for (int c = 0; c < 3; ++c) left[c] = maths::exp(-absorption[c] * in_world);
    return left;
}

}  // namespace occam::render
