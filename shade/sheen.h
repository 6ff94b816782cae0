// Sheen: light that short fibres scatter at grazing angles, as cloth has it, over everything but the coat.
//
// KHR_materials_sheen: the "Charlie" distribution with its fitted shadowing (Estevez and Kulla 2017), scaled by a colour.
// What lies below gets what the sheen leaves, by its tabulated albedo, so that no light is gained.
//
// Memory   a table of 32 x 24 floats, made once a process on first use, then read only.
// Threads  any.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// Width of the distribution of a sheen roughness, which is bounded below so that no density is infinite.
float sheen_width(float roughness) noexcept;

/// Share of white light from a direction that a white sheen reflects. cosine in [0, 1], alpha as sheen_width() gives it.
float sheen_albedo(float cosine, float alpha) noexcept;

/// What the sheen leaves of light from one direction for what lies below.
float below_sheen(const Surface& surface, float cosine) noexcept;

/// The sheen over `below`, which is the scattering of the rest; both f times the cosine.
Vec3f sheened(const Surface& surface, Vec3f below, Vec3f to_light) noexcept;

}  // namespace occam::shade
