// The limit of what light that was scattered twice or more brings to a pixel (Settings::clamp).
//
// What is limited is what comes to the pixel: the light that each pane, leaf and body on its way has left.
#pragma once

#include <algorithm>

#include "base/vec.h"

namespace occam::render {

/// Returns a contribution with its brightest channel limited, and in the same colour.
inline Vec3f limited(Vec3f radiance, float limit) noexcept
{
    const float brightest = std::max({radiance.x, radiance.y, radiance.z});
    return brightest > limit ? radiance * (limit / brightest) : radiance;
}

}  // namespace occam::render
