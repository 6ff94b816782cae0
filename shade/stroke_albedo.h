// The directional albedo of a single-scattering GGX layer with two widths, for one eye.
//
// With the albedo of the eye, the light that single scattering loses is given back as for isotropic layers, and the base
// gets what the layer leaves. A table over the direction and both widths that is as exact would be large, so the integral
// is taken anew for each eye.
//
// Space    the axes of the strokes: x along them, z the normal.
// Threads  any.
#pragma once

#include "shade/albedo_table.h"
#include "shade/microfacet.h"

namespace occam::shade {

/// Returns the albedo towards an eye, a unit direction with z above 0, to within 0.0012 (some three microseconds).
LayerAlbedo stroke_albedo(Vec3f eye, Widths widths) noexcept;

}  // namespace occam::shade
