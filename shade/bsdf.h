// The BSDF of a surface: a diffuse base or a rough pane under a GGX layer, or the boundary of a body that refracts light,
// with a clear coat over it (glTF 2.0, appendix B, and its extensions).
//
// Directions are unit vectors in world axes that point away from the surface. Radiance is divided by the squared
// refractive index, as if everything were vacuum, so it does not jump where light enters a body.
//
// Energy   The light that single scattering of the GGX layer or of a rough pane loses is given back (Kulla and Conty
//          2017). The base receives what the layer does not reflect, and everything below a coat receives what the coat
//          does not reflect to the eye. Bodies of glass lose nothing (transmission.h). So under uniform light a white
//          surface of any kind reflects or transmits all of it. The price is that coats and bodies are not reciprocal.
// Normals  Where the shading normal and the geometric normal differ, light is faded towards the geometric horizon (Chiang
//          et al. 2019), so that the light on coarse triangles with smooth normals does not end in a hard line. That
//          factor depends on the side of the light alone, so there, too, the function is not reciprocal. Bodies, and what
//          panes transmit, lose nothing there: directions on the wrong side of the facet are mirrored at it.
#pragma once

#include "shade/layer.h"
#include "shade/sheen.h"
#include "shade/surface.h"

namespace occam::shade {

/// Returns the two parts that the layer of a surface is a mixture of.
inline LayerMixOf<float> mix_of(const Surface& s) noexcept
{
    if (!s.is_mixed) return {s.f0, s.f90, 1, Vec3f(0), 0};
    return {s.dielectric_color, s.dielectric_f90, s.dielectric_share, s.base_color, s.metal_share};
}

/// Returns the factor of Chiang et al. 2019, eq. 1 to 3: it is 1 where the normals agree and falls smoothly to 0 at the
/// geometric horizon. `n_l` has to be above 0.
inline float terminator(const Surface& s, float n_l, Vec3f to_light) noexcept
{
    const float side = glm::dot(s.normal_geometric, to_light),
                along = std::max(n_l * glm::dot(s.normal_geometric, s.normal), 1e-6f);
    return faded(side, along);
}

/// Holds the probability of sampling each lobe, in proportion to what it sends to this eye.
struct LobeShares {
    float diffuse = 1, layer = 0, coat = 0, pane = 0, body = 0, sheen = 0;
    float multiple = 0, pane_multiple = 0;  ///< of light that bounces several times, reflected and through a pane
};

/// Holds a surface together with what its lobes are for its eye, whatever the direction of the light: this is computed once
/// for all lights and directions of a hit. A surface converts to it. It borrows the surface.
struct SurfaceForEye {
    const Surface& surface;
    // These are not set for a matte surface, which has no layer.
    LayerOf<float> layer;
    // What light of other directions does in a layer with strokes is taken from a round layer of its greater width: that
    // only distributes the light that the eye's albedo says is lost or let through.
    AlbedoTable::Row row;  ///< the layer's place in the table of albedos
    LayerAlbedo eye;       ///< albedo of the layer towards the eye
    float lost;            ///< what single scattering loses of the light of all directions
    float masking, root;   ///< ggx_masking_over_cosine() and ggx_root() of the eye
    SheenForEye sheen;     ///< what the sheen does with the light, if there is one
    float below_coat = 1;  ///< share of the light that the coat leaves to what is below it
    LobeShares shares;
    bool is_plain = false;  ///< There is no more than a base under a round layer.

    SurfaceForEye(const Surface& s) noexcept : surface(s)
    {
        if (!s.is_matte) set();
    }

private:
    void set() noexcept;
};

/// Computes scatter() for a surface that is not matte.
Vec3f scatter_of_lobes(const SurfaceForEye& surface, Vec3f to_light) noexcept;

/// Returns f(to_eye, to_light) times the cosine on the side of the light.
inline Vec3f scatter(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    if (!s.is_matte) return scatter_of_lobes(of, to_light);
    // This is bit for bit what scatter_of_lobes() gives where there is no layer.
    const float n_l = glm::dot(s.normal, to_light);
    return n_l > 0 ? s.diffuse * (1 / kPi) * (n_l * terminator(s, n_l, to_light)) : Vec3f(0);
}

/// Names the part of the surface from which a direction was drawn.
enum class Lobe : unsigned char { Diffuse, Layer, Coat, Transmission };

struct ScatterSample {
    Vec3f direction{0};  ///< unit
    Vec3f weight{0};     ///< scatter() / density; zero means that the sample is lost (below the horizon)
    float density = 0;   ///< per solid angle, of all lobes together
    Lobe lobe = Lobe::Diffuse;
    float alpha = 1;  ///< GGX width of the lobe; 1 for the diffuse base
};

/// Draws a direction that follows the lobes. `choice` selects the lobe and `square` the direction within it; both are
/// uniform in [0, 1).
ScatterSample sample_scatter(const SurfaceForEye& surface, float choice, Vec2f square) noexcept;

/// Returns the density of the directions of sample_scatter(), per solid angle.
float scatter_density(const SurfaceForEye& surface, Vec3f to_light) noexcept;

/// Holds scatter() and scatter_density() for one direction.
struct ScatterWithDensity {
    Vec3f light{0};
    float density = 0;
};
/// Returns both at once, with the same bits.
ScatterWithDensity scatter_with_density(const SurfaceForEye& surface, Vec3f to_light) noexcept;

/// Returns an upper bound of scatter_density() in any direction; it is infinite if light passes straight through the
/// surface.
float peak_density(const Surface& surface) noexcept;

/// Returns the GGX width of the narrowest lobe, or 1 if there is none.
inline float narrowest_lobe(const Surface& s) noexcept
{
    if (s.is_matte) return 1;
    const float layer = s.tangent != Vec3f(0) ? s.alpha_across : s.alpha;
    return s.coat > 0 ? std::min(layer, s.coat_alpha) : layer;
}

}  // namespace occam::shade
