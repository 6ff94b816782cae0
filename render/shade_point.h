// Converts a hit into the point that shading reads.
#pragma once

#include <cmath>

#include "accel/tracer.h"
#include "shade/shade_point.h"

namespace occam::render {

/// Returns the width of the texture filter at a hit, in pixels. A pixel is the mean of its samples, so each sample
/// filters only over its own share of the pixel.
inline float sample_width(int samples) noexcept { return 1 / std::sqrt(static_cast<float>(samples)); }

/// Returns the point to be shaded. It is valid as long as the hit.
/// texture_width   see sample_width()
shade::ShadePoint shade_point(const accel::Ray& ray, const accel::SurfaceHit& hit, float texture_width) noexcept;

}  // namespace occam::render
