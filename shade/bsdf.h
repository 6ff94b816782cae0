// How a surface scatters light: a diffuse base or a rough pane under a GGX layer, or the boundary of a body that bends
// light, and a clear coat over it (glTF 2.0, appendix B, and its extensions).
//
// Directions are unit, world axes, away from the point. Radiance is counted over the squared index, as if all were vacuum: it
// does not jump where light enters a body.
//
// Energy   what single scattering of the GGX layer loses is given back (Kulla and Conty 2017), and the base gets what the
//          layer does not reflect: a white surface under uniform light reflects all of it. Rough transmission alone is
//          single scattering: it loses up to 7 % at alpha = 0.1, 25 % at 0.3 and 65 % at 1 (from inside, or grazing).
// Normals  where shading and geometric normal differ, light is shaded off towards the geometric horizon (Chiang et al. 2019),
//          so that coarse triangles with smooth normals do not end their light in a hard line. That factor looks at the
//          light's side alone: there, and only there, the function is not reciprocal.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// f(to_eye, to_light) times the cosine at the light's side.
Vec3f scatter(const Surface& surface, Vec3f to_light) noexcept;

/// Which part of the surface a direction was drawn from.
enum class Lobe : unsigned char { Diffuse, Layer, Coat, Transmission };

struct ScatterSample {
    Vec3f direction{0};  ///< unit
    Vec3f weight{0};     ///< scatter() / density; zero: the sample is lost (below the horizon)
    float density = 0;   ///< per solid angle, of all lobes together
    Lobe lobe = Lobe::Diffuse;
    float alpha = 1;     ///< GGX width of the lobe; 1 for the diffuse base
};

/// A direction that follows the lobes. `choice` chooses among them, `square` within; both uniform in [0, 1).
ScatterSample sample_scatter(const Surface& surface, float choice, Vec2f square) noexcept;

/// Density of sample_scatter()'s directions per solid angle.
float scatter_density(const Surface& surface, Vec3f to_light) noexcept;

/// No lobe of the surface draws any direction more densely; infinity if light passes through it.
float peak_density(const Surface& surface) noexcept;

/// GGX width of the narrowest lobe; 1 if there is none.
inline float narrowest_lobe(const Surface& s) noexcept
{
    if (s.is_matte) return 1;
    return s.coat > 0 ? std::min(s.alpha, s.coat_alpha) : s.alpha;
}

}  // namespace occam::shade
