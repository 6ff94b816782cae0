// A material's parameters at one point, textures looked up and factors applied: all that the BSDF reads.
#pragma once

#include "scenegraph/texture/texture_store.h"
#include "shade/shade_point.h"

namespace occam::shade {

/// Colours are linear Rec.709; vectors are unit, world axes.
struct Surface {
    Vec3d origin{0};  ///< where secondary rays start: the point, moved off its own surface
    Vec3f to_eye{0, 0, 1};
    Vec3f normal_geometric{0, 0, 1};
    Vec3f normal{0, 0, 1};  ///< of shading

    Vec3f base_color{0};  ///< factor, texture and vertex colour
    float opacity = 1;    ///< 1 unless the material blends
    Vec3f emission{0};
    bool unlit = false;  ///< base_color is the radiance; nothing else counts

    Vec3f diffuse{0};  ///< base_color times what is not metal
    Vec3f f0{0.04f};   ///< reflectance at normal incidence, dielectric and metal mixed
    float f90 = 1;     ///< at grazing incidence
    float dielectric_f0 = 0.04f,
          dielectric_f90 = 1;  ///< of the dielectric alone: what it reflects does not reach the diffuse base
    float alpha = 0.36f;       ///< GGX width, roughness squared
    float coat = 0;            ///< share of the clear coat
    float coat_alpha = 0;
};

/// Narrowest GGX lobe: a mirror is drawn as a lobe of this width, so that no density is infinite.
inline constexpr float kMinAlpha = 1e-3f;

Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept;

}  // namespace occam::shade
