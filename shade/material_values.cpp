#include "shade/material_values.h"

#include <algorithm>

#include "scenegraph/map_axes.h"
#include "shade/bump.h"

namespace occam::shade {
namespace {

Vec4f texel(const TextureUse& use, const lod::VertexToShade& at, const TextureStore& textures) noexcept
{
    if (!use) return Vec4f(1);
    const int set = coordinates_of(use);
    return textures.sample(use, at.uv[set], at.uv_width[set]);
}

// Calls visit(first float, number of floats) for every value that is made at vertices.
template <class Values, class Visit>
void for_each_packed(const Material& m, Values& v, Visit&& visit) noexcept
{
    if (m.alpha_mode != AlphaMode::Mask && m.base_color_texture) visit(&v.base_color.x, 4);
    if (m.alpha_mode == AlphaMode::Blend && m.alpha_texture) visit(&v.alpha, 1);
    if (m.unlit) return;
    if (m.metallic_roughness_texture || m.metallic_texture) visit(&v.metallic, 1);
    if (m.metallic_roughness_texture || m.roughness_texture || m.glossiness_texture) visit(&v.roughness, 1);
    if (m.emission_texture && m.emission != Vec3f(0)) visit(&v.emission.x, 3);
    if (m.normal_texture) visit(&v.normal.x, 3);
    if (m.bump_texture) visit(&v.rise.x, 2);
    if (m.occlusion_texture) visit(&v.occlusion, 1);
    if (m.specular_texture) visit(&v.specular, 1);
    if (m.specular_color_texture) visit(&v.specular_color.x, 3);
    if (m.sheen_color != Vec3f(0) && m.sheen_color_texture) visit(&v.sheen_color.x, 3);
    if (m.sheen_color != Vec3f(0) && m.sheen_roughness_texture) visit(&v.sheen_roughness, 1);
    if (m.anisotropy > 0 && m.anisotropy_texture) visit(&v.anisotropy.x, 3);
    if (m.transmission > 0 && m.transmission_texture) visit(&v.transmission, 1);
    if (!(m.clearcoat > 0)) return;
    if (m.clearcoat_texture) visit(&v.coat, 1);
    if (m.clearcoat_roughness_texture) visit(&v.coat_roughness, 1);
    if (m.clearcoat_normal_texture) visit(&v.coat_normal.x, 3);
}

// Returns whether what lies under transparent texels must not be seen between vertices, as it is not between texels.
bool weights_by_alpha(const Material& m) noexcept { return m.alpha_mode == AlphaMode::Blend && m.base_color_texture; }

}  // namespace

MaterialValues::MaterialValues(const Material& m) noexcept
    : base_color(m.base_color),
      metallic(m.metallic),
      roughness(m.roughness),
      emission(m.emission),
      specular(m.specular),
      specular_color(m.specular_color),
      sheen_color(m.sheen_color),
      sheen_roughness(m.sheen_roughness),
      transmission(m.transmission),
      coat(m.clearcoat),
      coat_roughness(m.clearcoat_roughness)
{
}

void MaterialValues::look_up_color(const Material& m, const lod::VertexToShade& at, const TextureStore& textures) noexcept
{
    base_color = m.base_color * texel(m.base_color_texture, at, textures);
    if (m.alpha_mode == AlphaMode::Mask) look_up_mask(m, at, textures);
    else alpha = texel(m.alpha_texture, at, textures).x;
}

void MaterialValues::look_up_mask(const Material& m, const lod::VertexToShade& at, const TextureStore& textures) noexcept
{
    const lod::VertexToShade point{{at.uv[0], at.uv[1]}, {}};
    base_color.w = m.base_color.w * texel(m.base_color_texture, point, textures).w;
    alpha = texel(m.alpha_texture, point, textures).x;
}

void MaterialValues::look_up_rest(const Material& m, const lod::VertexToShade& at, const TextureStore& textures) noexcept
{
    const auto look_up = [&](const TextureUse& use) { return texel(use, at, textures); };
    const Vec4f rough_metal = look_up(m.metallic_roughness_texture);
    metallic = m.metallic * rough_metal.z * look_up(m.metallic_texture).z;
    roughness = m.roughness * rough_metal.y * look_up(m.roughness_texture).y;
    if (m.glossiness_texture) roughness = 1 - (1 - roughness) * look_up(m.glossiness_texture).w;
    if (m.sheen_color != Vec3f(0)) {
        sheen_color = m.sheen_color * Vec3f(look_up(m.sheen_color_texture));
        sheen_roughness = m.sheen_roughness * look_up(m.sheen_roughness_texture).w;
    }
    if (m.anisotropy > 0 && m.anisotropy_texture) {
        const Vec3f texel = Vec3f(look_up(m.anisotropy_texture));
        anisotropy = {texel.x * 2 - 1, texel.y * 2 - 1, texel.z};
    }
    if (m.emission != Vec3f(0)) emission = m.emission * Vec3f(look_up(m.emission_texture));
    if (m.normal_texture) normal = Vec3f(look_up(m.normal_texture)) * 2.0f - 1.0f;
    specular = m.specular * look_up(m.specular_texture).w;
    specular_color = m.specular_color * Vec3f(look_up(m.specular_color_texture));
    if (m.transmission > 0) transmission = m.transmission * look_up(m.transmission_texture).x;
    if (!(m.clearcoat > 0)) return;
    coat = m.clearcoat * look_up(m.clearcoat_texture).x;
    coat_roughness = m.clearcoat_roughness * look_up(m.clearcoat_roughness_texture).y;
    if (m.clearcoat_normal_texture) coat_normal = Vec3f(look_up(m.clearcoat_normal_texture)) * 2.0f - 1.0f;
}

void MaterialValues::look_up_occlusion(const Material& m, const lod::VertexToShade& at,
                                       const TextureStore& textures) noexcept
{
    if (!m.occlusion_texture) return;
    const float open = std::max(texel(m.occlusion_texture, at, textures).x, 0.0f);
    occlusion = std::clamp(1 + m.occlusion_strength * (open - 1), 0.0f, 1.0f);
}

int packed_floats(const Material& material) noexcept
{
    int count = 0;
    const MaterialValues values(material);
    for_each_packed(material, values, [&](const float*, int floats) { count += floats; });
    return count;
}

void pack(const Material& material, MaterialValues values, float* to) noexcept
{
    if (weights_by_alpha(material))
        values.base_color = Vec4f(Vec3f(values.base_color) * values.base_color.w, values.base_color.w);
    for_each_packed(material, values, [&](const float* from, int floats) { to = std::copy_n(from, floats, to); });
}

MaterialValues unpack(const Material& material, const float* from) noexcept
{
    MaterialValues values(material);
    for_each_packed(material, values, [&](float* to, int floats) {
        std::copy_n(from, floats, to);
        from += floats;
    });
    if (const float alpha = values.base_color.w; weights_by_alpha(material) && alpha > 0)
        values.base_color = Vec4f(Vec3f(values.base_color) / alpha, alpha);
    return values;
}

void PhaseOne::shade(const Material& material, const lod::LatticeToShade& lattice, float* out) const noexcept
{
    const int floats = packed_floats(material);
    const BumpLattice bump(material, lattice, textures_);
    for (int k = 0; k < static_cast<int>(lattice.vertices.size()); ++k) {
        const lod::VertexToShade& at = lattice.vertices[static_cast<std::size_t>(k)];
        MaterialValues values(material);
        if (material.alpha_mode != AlphaMode::Mask) values.look_up_color(material, at, textures_);
        if (!material.unlit) {
            values.look_up_rest(material, at, textures_);
            values.look_up_occlusion(material, at, textures_);
            values.rise = bump.rise(k % lattice.columns, k / lattice.columns);
        }
        pack(material, values, out);
        out += floats;
    }
}

}  // namespace occam::shade
