// Phase two of shading begins: a material's parameters at one point, seen from one side: all that the BSDF reads.
//
// glTF 2.0 metallic-roughness with KHR_materials_ior, _specular, _clearcoat, _sheen, _anisotropy, _transmission, _volume,
// _emissive_strength and _unlit. Where it leaves them: both sides of every face are seen (as path tracers do; double_sided
// decides nothing), and occlusion maps dim no light whose way is traced (ambient_share).
#pragma once

#include "io/texture/texture_store.h"
#include "shade/microfacet.h"
#include "shade/shade_point.h"

namespace occam::shade {

/// Colours are linear Rec.709; vectors are unit, world axes.
struct Surface {
    Vec3d position{0};
    Vec3d start_point{0};         ///< on the mesh that secondary rays see
    Vec3f start_normal{0, 0, 1};  ///< of the mesh there, on the side of normal_geometric
    float self_distance = 0;
    Vec3f to_eye{0, 0, 1};
    Vec3f normal_geometric{0, 0, 1};  ///< on the side of to_eye
    Vec3f normal{0, 0, 1};            ///< of shading, with the normal map
    Vec3f coat_normal{0, 0, 1};       ///< the coat lies smoothly over the normal map, or has one of its own

    Vec3f base_color{0};  ///< factor, texture and vertex colour
    float opacity = 1;    ///< share that is there at all; below 1 where the material blends, 0 or 1 where it masks
    Vec3f passes{0};      ///< share of light that goes straight on: what is not there, and smooth thin glass
    Vec3f emission{0};    ///< towards the eye, the coat's share taken off
    bool unlit = false;   ///< base_color is the radiance; nothing else counts

    Vec3f diffuse{0};  ///< base_color times what is neither metal nor glass
    Vec3f f0{0.04f};   ///< reflectance at normal incidence, dielectric and metal mixed
    float f90 = 1;     ///< at grazing incidence
    float dielectric_f0 = 0.04f,
          dielectric_f90 = 1;  ///< of the dielectric alone: what it reflects does not reach the base below it
    float alpha = 0.36f;       ///< GGX width, roughness squared
    Vec3f tangent{0};          ///< across the normal: the direction of brush strokes; zero: the layer's lobe is round
    float alpha_along = 0,
          alpha_across = 0;  ///< GGX widths of such a layer, along the strokes and across; alpha is their mean
    Vec3f sheen{0};          ///< colour of the sheen (shade/sheen.h); zero: there is none
    float sheen_alpha = 1;   ///< its width
    float coat = 0;          ///< share of the clear coat
    float coat_alpha = kMinAlpha;

    bool is_matte = false;  ///< nothing but `diffuse` scatters light: what follows from that is not worked out again

    Vec3f transmission{0};       ///< tint of what a rough thin pane, or a solid body, lets through; zero: nothing
    bool is_solid = false;       ///< Light is refracted (KHR_materials_volume); otherwise the surface is a thin pane.
    float solid_share = 1;       ///< Solid: the share of the surface that is glass. The rest is as f0 and diffuse say.
    float eta = 1;               ///< solid: refractive index behind the surface over that on the eye's side
    Vec3f absorption_inside{0};  ///< solid: per world length inside of the body (Beer-Lambert)

    /// Returns where a ray in that direction starts: off the mesh that it sees by more than rounding, to the side that it
    /// leaves by.
    Vec3d start(Vec3f direction) const noexcept
    {
        const float side = glm::dot(normal_geometric, direction) < 0 ? -self_distance : self_distance;
        return start_point + Vec3d(start_normal) * double(side);
    }
};

/// `point.material` is never null; textures must be prepared.
Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept;

/// Share of light that goes straight on at the point: evaluate().passes, without the rest.
Vec3f passes_straight(const ShadePoint& point, const TextureStore& textures) noexcept;

/// What the material's occlusion map leaves of ambient light, 0 to 1: of light that is not traced to where it comes from.
/// Nobody else reads the map: rays find what it stands for.
float ambient_share(const ShadePoint& point, const TextureStore& textures) noexcept;

/// True if some point of the material may let light pass straight on.
bool may_pass(const Material& material) noexcept;

}  // namespace occam::shade
