// The reflection of a surface: a diffuse base under a GGX layer, and a clear coat over both (glTF 2.0, appendix B).
//
// Directions are unit, world axes, away from the point. Single scattering: the roughest metals lose two thirds of the light.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// f(to_eye, to_light) times the cosine at the light's side; zero below either side of the surface.
Vec3f reflect(const Surface& surface, Vec3f to_light) noexcept;

/// A direction that follows the lobes. `lobe` chooses among them, `square` within; both uniform in [0, 1).
/// May point below the surface: reflect() is zero there.
Vec3f sample_direction(const Surface& surface, float lobe, Vec2f square) noexcept;

/// Density of sample_direction() per solid angle.
float direction_density(const Surface& surface, Vec3f to_light) noexcept;

}  // namespace occam::shade
