// How a surface scatters light: a diffuse base or a rough pane under a GGX layer, or the boundary of a body that bends
// light, and a clear coat over it (glTF 2.0, appendix B, and its extensions).
//
// Directions are unit, world axes, away from the point. Radiance is counted over the squared index, as if all were vacuum:
// it does not jump where light enters a body.
//
// Energy   what single scattering of the GGX layer, or of a rough pane, loses is given back (Kulla and Conty 2017), the base
//          gets what the layer does not reflect, and what lies below a coat what the coat does not reflect to the eye.
//          Bodies of glass lose nothing (transmission.h). So under uniform light a white surface of any kind reflects, or
//          lets through, all of it. Coats and bodies are not reciprocal for that.
// Normals  where shading and geometric normal differ, light is shaded off towards the geometric horizon (Chiang et al.
//          2019), so that coarse triangles with smooth normals do not end their light in a hard line. That factor looks at
//          the light's side alone: there too the function is not reciprocal.
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// Chiang et al. 2019, eq. 1 to 3: 1 where the normals agree, falling smoothly to 0 at the geometric horizon. n_l: above 0.
inline float terminator(const Surface& s, float n_l, Vec3f to_light) noexcept
{
    const float side = glm::dot(s.normal_geometric, to_light),
                along = std::max(n_l * glm::dot(s.normal_geometric, s.normal), 1e-6f);
    if (side >= along) return 1;
    if (!(side > 0)) return 0;
    const float ratio = side / along;
    return ratio * (1 + ratio * (1 - ratio));
}

/// scatter() of a surface that is not, or need not be, matte.
Vec3f scatter_of_lobes(const Surface& surface, Vec3f to_light) noexcept;

/// f(to_eye, to_light) times the cosine at the light's side.
inline Vec3f scatter(const Surface& s, Vec3f to_light) noexcept
{
    if (!s.is_matte) return scatter_of_lobes(s, to_light);
    // What the lobes come to, bit by bit, where the layer is nothing.
    const float n_l = glm::dot(s.normal, to_light);
    return n_l > 0 ? s.diffuse * (1 / kPi) * (n_l * terminator(s, n_l, to_light)) : Vec3f(0);
}

/// Which part of the surface a direction was drawn from.
enum class Lobe : unsigned char { Diffuse, Layer, Coat, Transmission };

struct ScatterSample {
    Vec3f direction{0};  ///< unit
    Vec3f weight{0};     ///< scatter() / density; zero: the sample is lost (below the horizon)
    float density = 0;   ///< per solid angle, of all lobes together
    Lobe lobe = Lobe::Diffuse;
    float alpha = 1;  ///< GGX width of the lobe; 1 for the diffuse base
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
    const float layer = s.tangent != Vec3f(0) ? s.alpha_across : s.alpha;
    return s.coat > 0 ? std::min(layer, s.coat_alpha) : layer;
}

}  // namespace occam::shade
