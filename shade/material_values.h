// Phase one of shading: what a material is at a point, from wherever it is seen. Textures looked up, factors applied.
//
// Djeu et al. 2011, sec. 5.3. Every value is linear in its texels, so that values made at grid vertices and interpolated to
// a hit are what the texels, interpolated, would give. Colours are linear Rec.709.
#pragma once

#include "io/texture/texture_store.h"
#include "lod/vertex_shader.h"

namespace occam::shade {

struct MaterialValues {
    /// Of the factors alone.
    explicit MaterialValues(const Material& material) noexcept;

    Vec4f base_color;  ///< without the vertex colour
    float alpha = 1;   ///< of the map of its own; base_color.w apart
    float metallic, roughness;
    Vec3f emission;
    Vec3f normal{0, 0, 1};  ///< in the axes of the normal map, not scaled, not unit
    Vec3f slope{0};         ///< gradient of the bump map's height over the surface, world axes
    float occlusion = 1;    ///< share of ambient light that arrives
    float specular;
    Vec3f specular_color;
    Vec3f sheen_color;
    float sheen_roughness;
    Vec3f anisotropy{1, 0, 1};  ///< direction in the axes of the normal map, not turned, not unit; strength over the factor
    float transmission;
    float coat, coat_roughness;
    Vec3f coat_normal{0, 0, 1};

    /// Base colour and alpha: all that tells whether there is anything to shade.
    void look_up_color(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
    /// All but the occlusion, which few ask for, and the slope, which takes more than one place (shade/bump.h).
    void look_up_rest(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
    void look_up_occlusion(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
};

/// Values that have a map and are made at vertices, one after the other: how many floats. Alpha that masks is a hit's own,
/// for its edge would be as wide as vertices are apart; so is the base colour, which comes with it.
int packed_floats(const Material& material) noexcept;
void pack(const Material& material, const MaterialValues& values, float* to) noexcept;
/// Values of the material at a hit: those packed, and the factors of the rest.
MaterialValues unpack(const Material& material, const float* from) noexcept;

/// Phase one at grid vertices.
class PhaseOne final : public lod::VertexShader {
public:
    explicit PhaseOne(const TextureStore& textures) noexcept : textures_(textures) {}

    int channels(const Material& material) const noexcept override { return packed_floats(material); }
    void shade(const Material& material, const lod::LatticeToShade& lattice, float* out) const noexcept override;

private:
    const TextureStore& textures_;
};

}  // namespace occam::shade
