// Phase one of shading: the values of a material at a point, which do not depend on the view. Textures are looked up and
// factors applied.
//
// Djeu et al. 2011, sec. 5.3. Every value is linear in the texels of each map, so values that are made at grid vertices
// and interpolated to a hit equal what the interpolated texels would give, except where two maps are multiplied: there they
// are close to it. Colours that alpha covers in part are interpolated with it as their weight. None of the values depends on
// where the surface is, which may move while the shutter is open. Colours are linear Rec.709.
#pragma once

#include "io/texture/texture_store.h"
#include "lod/vertex_shader.h"

namespace occam::shade {

struct MaterialValues {
    /// Takes the factors of the material alone, without textures.
    explicit MaterialValues(const Material& material) noexcept;

    Vec4f base_color;  ///< without the vertex colour
    float alpha = 1;   ///< from the material's alpha map; base_color.w is not part of it
    float metallic, roughness;
    Vec3f emission;
    Vec3f normal{0, 0, 1};  ///< in the axes of the normal map, neither scaled nor normalised
    Vec2f rise{0};          ///< derivatives of the height of the bump map, in world lengths, by its coordinates
    float occlusion = 1;    ///< share of ambient light that arrives
    float specular;
    Vec3f specular_color;
    Vec3f sheen_color;
    float sheen_roughness;
    Vec3f anisotropy{
        1, 0, 1};  ///< direction in the axes of the normal map, neither rotated nor normalised; strength over the factor
    float transmission;
    float coat, coat_roughness;
    Vec3f coat_normal{0, 0, 1};

    /// Looks up base colour and alpha, which decide whether there is anything to shade.
    void look_up_color(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
    /// Looks up the alpha of a mask alone. It has no filter, because what is compared with the cutoff cannot be averaged
    /// before: of a mask that has holes everywhere, all or nothing would be left far away.
    void look_up_mask(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
    /// Looks up everything except the occlusion, which is rarely needed, and the rise, which takes more than one
    /// lookup (shade/bump.h).
    void look_up_rest(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
    void look_up_occlusion(const Material& material, const lod::VertexToShade& at, const TextureStore& textures) noexcept;
};

/// Returns the number of floats of the values that have a map and are made at vertices, stored one after the other. An
/// alpha mask is looked up at hits, because its edge would otherwise be as wide as the distance between vertices; so is
/// the base colour, which comes with it.
int packed_floats(const Material& material) noexcept;
void pack(const Material& material, MaterialValues values, float* to) noexcept;
/// Returns the values of the material at a hit: the packed ones, and the factors of the rest.
MaterialValues unpack(const Material& material, const float* from) noexcept;

/// The shader that computes phase one at grid vertices.
class PhaseOne final : public lod::VertexShader {
public:
    explicit PhaseOne(const TextureStore& textures) noexcept : textures_(textures) {}

    int channels(const Material& material) const noexcept override { return packed_floats(material); }
    void shade(const Material& material, const lod::LatticeToShade& lattice, float* out) const noexcept override;

private:
    const TextureStore& textures_;
};

}  // namespace occam::shade
