// Debug views: the colour of a hit shows one fact about it.
#pragma once

#include "accel/tracer.h"
#include "render/settings.h"

namespace occam::render {

/// Returns the colour of a hit.
/// z        camera z of the hit; shown from white at z_near to black at z_far
Vec3f view_color(View view, const accel::SurfaceHit& hit, float z, float z_near, float z_far) noexcept;
/// Returns the colour of a camera ray in a view that shows its cost.
Vec3f cost_color(View view, const accel::RayCost& cost) noexcept;

}  // namespace occam::render
