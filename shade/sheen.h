// Sheen: light that short fibres scatter at grazing angles, as on cloth. It lies over everything but the coat.
//
// KHR_materials_sheen: the "Charlie" distribution with its fitted shadowing (Estevez and Kulla 2017), scaled by a colour.
// The layers below receive what the sheen does not reflect, by its tabulated albedo, so that no light is gained.
//
// Memory   a table of 32 x 24 floats, made once per process on first use, and read only from then on.
// Threads  any.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// Returns the width of the distribution for a sheen roughness. It is bounded below so that no density is infinite.
float sheen_width(float roughness) noexcept;

/// Returns the share of light from a direction that a white sheen reflects. `cosine` is in [0, 1], and `alpha` is what
/// sheen_width() returns.
float sheen_albedo(float cosine, float alpha) noexcept;

/// Returns the share of light from one direction that the sheen leaves for the layers below it.
float below_sheen(const Surface& surface, float cosine) noexcept;

/// Returns the sheen over `below`, which is the scattering of the rest; both are f times the cosine.
Vec3f sheened(const Surface& surface, Vec3f below, Vec3f to_light) noexcept;

}  // namespace occam::shade
