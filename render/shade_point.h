// From what a ray met to what shading reads.
#pragma once

#include <cmath>

#include "accel/tracer.h"
#include "shade/shade_point.h"

namespace occam::render {

/// Of the textures' filter at a hit, in pixels: a pixel is the mean of its samples, and each filters over its own share of
/// it alone.
inline float sample_width(int samples) noexcept { return 1 / std::sqrt(static_cast<float>(samples)); }

/// Good as long as the hit.
/// texture_width   see sample_width()
shade::ShadePoint shade_point(const accel::Ray& ray, const accel::SurfaceHit& hit, float texture_width) noexcept;

}  // namespace occam::render
