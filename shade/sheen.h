// Sheen: light that short fibres scatter at grazing angles, as on cloth. It lies over everything but the coat.
//
// KHR_materials_sheen: the "Charlie" distribution with its fitted shadowing (Estevez and Kulla 2017), scaled by a colour.
// Narrow distributions would reflect up to three times the light that falls on them at grazing angles, so a sheen whose
// albedo exceeds 1 is divided by it. What is below the sheen receives what the sheen does not reflect to the eye, as below
// the coat: all light is accounted for, whatever the base does with it, and the function is not reciprocal.
//
// Memory   a table of 96 x 64 floats, made once per process on first use (some 70 ms), and read only from then on.
// Threads  any.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// Returns the width of the distribution for a sheen roughness. It is bounded below so that no density is infinite.
float sheen_width(float roughness) noexcept;

/// Holds what the sheen of a surface does with the light towards one eye, whatever its direction.
struct SheenForEye {
    float reflects = 0;  ///< share of light that a white sheen reflects, in [0, 1]
    float scale = 1;     ///< factor of the distribution, which keeps its albedo from exceeding 1
    float below = 1;     ///< share of light that the sheen leaves for the layers below it
};

/// Returns what the surface's sheen does for an eye at this cosine, in [0, 1], to the normal.
SheenForEye sheen_for_eye(const Surface& surface, float cosine) noexcept;

/// Returns the sheen over `below`, which is the scattering of the rest; both are f times the cosine.
Vec3f sheened(const Surface& surface, const SheenForEye& eye, Vec3f below, Vec3f to_light) noexcept;

}  // namespace occam::shade
