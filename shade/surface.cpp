#include "shade/surface.h"

#include <algorithm>

namespace occam::shade {
namespace {

Vec4f texel(const TextureUse& use, const ShadePoint& point, const TextureStore& textures) noexcept
{
    if (!use) return Vec4f(1);
    const int set = std::clamp(use.uv_set, 0, 1);
    return textures.sample(use, point.uv[set], point.uv_width[set]);
}

float lobe_width(float roughness) noexcept
{
    const float r = std::clamp(roughness, 0.0f, 1.0f);
    return std::max(r * r, kMinAlpha);
}

float opacity_of(const Material& material, float alpha) noexcept
{
    return material.alpha_mode == AlphaMode::Blend ? std::clamp(alpha, 0.0f, 1.0f) : 1.0f;
}

}  // namespace

Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept
{
    const Material& m = *point.material;
    Surface s;
    s.origin = point.position + Vec3d(point.normal_geometric) * double(point.self_distance);
    s.to_eye = point.to_eye;
    s.normal_geometric = point.normal_geometric;
    s.normal = point.normal_shading;

    const Vec4f base = m.base_color * texel(m.base_color_texture, point, textures) * point.color;
    s.base_color = Vec3f(base);
    s.opacity = opacity_of(m, base.w * texel(m.alpha_texture, point, textures).x);
    s.unlit = m.unlit;
    if (s.unlit) return s;
    s.emission = m.emission == Vec3f(0) ? Vec3f(0) : m.emission * Vec3f(texel(m.emission_texture, point, textures));

    const Vec4f rough_metal = texel(m.metallic_roughness_texture, point, textures);
    const float metallic = std::clamp(m.metallic * rough_metal.z * texel(m.metallic_texture, point, textures).z, 0.0f, 1.0f);
    s.alpha = lobe_width(m.roughness * rough_metal.y * texel(m.roughness_texture, point, textures).y);
    s.diffuse = s.base_color * (1 - metallic);

    // KHR_materials_ior and KHR_materials_specular: reflectance of the dielectric at both ends of the angle.
    const float root = (m.ior - 1) / (m.ior + 1);
    const float strength = m.specular * texel(m.specular_texture, point, textures).w;
    const Vec3f tint = m.specular_color * Vec3f(texel(m.specular_color_texture, point, textures));
    const Vec3f dielectric = glm::min(root * root * tint, Vec3f(1)) * strength;
    s.dielectric_f0 = std::max({dielectric.x, dielectric.y, dielectric.z});
    s.dielectric_f90 = strength;
    s.f0 = dielectric * (1 - metallic) + s.base_color * metallic;
    s.f90 = strength * (1 - metallic) + metallic;

    if (m.clearcoat > 0) {
        s.coat = std::clamp(m.clearcoat * texel(m.clearcoat_texture, point, textures).x, 0.0f, 1.0f);
        s.coat_alpha = lobe_width(m.clearcoat_roughness * texel(m.clearcoat_roughness_texture, point, textures).y);
    }
    return s;
}

}  // namespace occam::shade
