// The material model: glTF 2.0 metallic-roughness and the extensions that a renderer needs. Colours are linear Rec.709.
#pragma once

#include <array>
#include <concepts>
#include <string>
#include <type_traits>

#include "base/vec.h"
#include "scenegraph/ids.h"

namespace occam {

/// One use of a texture: its coordinates, their transform (KHR_texture_transform), and how it repeats.
struct TextureUse {
    enum class Wrap : unsigned char { Repeat, Clamp, Mirror };

    TextureId texture{};  ///< none: only the factor beside it counts
    int uv_set = 0;       ///< 0 or 1; a displacement may use any that the cage has
    Vec2f offset{0}, scale{1};
    float rotation = 0;  ///< radians, counter-clockwise about the origin of st (KHR_texture_transform)
    Wrap wrap_s = Wrap::Repeat, wrap_t = Wrap::Repeat;
    bool nearest = false;  ///< magnification without interpolation

    explicit operator bool() const noexcept { return bool(texture); }
};

enum class AlphaMode : unsigned char { Opaque, Mask, Blend };

struct Material {
    std::string name{};
    Vec4f base_color{1};
    TextureUse base_color_texture{};
    float metallic = 0, roughness = 0.6f;
    TextureUse metallic_roughness_texture{};  ///< G roughness, B metallic
    TextureUse roughness_texture{};   ///< G; multiplies that of metallic_roughness_texture (separate maps: MTL's map_Pr)
    TextureUse metallic_texture{};    ///< B; as above (MTL's map_Pm)
    TextureUse glossiness_texture{};  ///< A; multiplies 1 - roughness (KHR_materials_pbrSpecularGlossiness)
    Vec3f emission{0};                ///< emissiveFactor times KHR_materials_emissive_strength
    TextureUse emission_texture{};
    TextureUse normal_texture{};
    float normal_scale = 1;
    TextureUse bump_texture{};       ///< R: heights that change normals but not positions (Blinn 1978)
    float bump_scale = 1;            ///< height of a texel of 1, world length
    TextureUse occlusion_texture{};  ///< R: share of ambient light that arrives
    float occlusion_strength = 1;    ///< 0: all ambient light arrives, whatever the texture says
    TextureUse alpha_texture{};      ///< R; times the alpha of the base colour (MTL's map_d)
    AlphaMode alpha_mode = AlphaMode::Opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false;      ///< KHR_materials_unlit
    float ior = 1.5f;        ///< KHR_materials_ior; 0: reflects as much as specular_color allows
    float transmission = 0;  ///< KHR_materials_transmission
    TextureUse transmission_texture{};
    float thickness = 0;  ///< KHR_materials_volume: above 0 the surface bounds a refracting body; its value is not read
    Vec3f attenuation_color{1};                    ///< colour of light after attenuation_distance inside that body
    float attenuation_distance = 0;                ///< world length; 0: the body is clear
    float clearcoat = 0, clearcoat_roughness = 0;  ///< KHR_materials_clearcoat
    TextureUse clearcoat_texture{}, clearcoat_roughness_texture{}, clearcoat_normal_texture{};
    float clearcoat_normal_scale = 1;
    float specular = 1;  ///< KHR_materials_specular
    Vec3f specular_color{1};
    TextureUse specular_texture{}, specular_color_texture{};
    Vec3f sheen_color{0};  ///< KHR_materials_sheen; black: there is no sheen
    float sheen_roughness = 0;
    TextureUse sheen_color_texture{}, sheen_roughness_texture{};
    float anisotropy = 0;             ///< KHR_materials_anisotropy: strength, 0 to 1; 0: the lobe is round
    float anisotropy_rotation = 0;    ///< radians, counter-clockwise from the tangent to the direction of the brush strokes
    TextureUse anisotropy_texture{};  ///< RG the direction, B the strength
};

/// Returns pointers to all uses of textures by a material: an array of TextureUse*, or of const TextureUse* if it is const.
auto texture_uses(auto& m) noexcept requires std::derived_from<std::remove_cvref_t<decltype(m)>, Material>
{
    return std::array{&m.base_color_texture,
                      &m.metallic_roughness_texture,
                      &m.roughness_texture,
                      &m.metallic_texture,
                      &m.glossiness_texture,
                      &m.emission_texture,
                      &m.normal_texture,
                      &m.bump_texture,
                      &m.occlusion_texture,
                      &m.alpha_texture,
                      &m.transmission_texture,
                      &m.clearcoat_texture,
                      &m.clearcoat_roughness_texture,
                      &m.clearcoat_normal_texture,
                      &m.specular_texture,
                      &m.specular_color_texture,
                      &m.sheen_color_texture,
                      &m.sheen_roughness_texture,
                      &m.anisotropy_texture};
}

}  // namespace occam
