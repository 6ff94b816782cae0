// Debug views: the colour of a hit shows one fact about it.
#pragma once

#include "accel/tracer.h"
#include "render/settings.h"
#include "scenegraph/scene.h"

namespace occam::render {

/// Returns the colour of a hit.
/// z        camera z of the hit; shown from white at z_near to black at z_far
/// scene    tells the cages of a node apart; may be null, and then all of them are the first one
Vec3f view_color(View view, const accel::SurfaceHit& hit, float z, float z_near, float z_far, const Scene* scene) noexcept;
/// Returns the colour of a camera ray in a view that shows its cost.
Vec3f cost_color(View view, const accel::RayCost& cost) noexcept;

}  // namespace occam::render
