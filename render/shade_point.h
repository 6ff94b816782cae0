// From what a ray met to what shading reads.
#pragma once

#include "accel/tracer.h"
#include "shade/shade_point.h"

namespace occam::render {

/// texture_width   of one sample, in pixels: a pixel is the mean of its samples, and each filters textures over its own share
shade::ShadePoint shade_point(const accel::Ray& ray, const accel::SurfaceHit& hit, float texture_width) noexcept;

}  // namespace occam::render
