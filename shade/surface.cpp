#include "shade/surface.h"

#include <algorithm>

#include "shade/albedo_table.h"
#include "shade/fresnel.h"

namespace occam::shade {
namespace {

// Thin glass that is smoother than this does not scatter what it lets through: light and shadow rays go straight on.
constexpr float kClearRoughness = 0.05f;
// A body whose index is nearer to that of the outside does not bend light at all.
constexpr float kLeastBend = 1e-3f;

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
    switch (material.alpha_mode) {
        case AlphaMode::Opaque: break;
        case AlphaMode::Mask: return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
        case AlphaMode::Blend: return std::clamp(alpha, 0.0f, 1.0f);
    }
    return 1;
}

// Normal from a map (glTF 2.0, sec. 3.9.3), about the interpolated one, on its side. Axes are those of the coordinates after
// KHR_texture_transform.
Vec3f mapped_normal(const TextureUse& use, float scale, const ShadePoint& p, const TextureStore& textures) noexcept
{
    if (!use || p.tangent == Vec3f(0)) return p.normal_shading;
    const Vec3f outward = p.back_side ? -p.normal_shading : p.normal_shading;
    Vec3f right = p.tangent, up = glm::cross(outward, p.tangent) * p.tangent_sign;
    if (use.rotation != 0 || use.scale.x < 0 || use.scale.y < 0) {
        const float s = maths::sin(use.rotation), c = maths::cos(use.rotation);
        const float sx = use.scale.x < 0 ? -1.0f : 1.0f, sy = use.scale.y < 0 ? -1.0f : 1.0f;
        const Vec3f turned = right * (c * sx) - up * (s * sy);
        up = right * (s * sx) + up * (c * sy);
        right = turned;
    }
    const Vec3f t = Vec3f(texel(use, p, textures)) * 2.0f - 1.0f;
    const Vec3f n = right * (t.x * scale) + up * (t.y * scale) + outward * t.z;
    const float length = glm::length(n);
    if (!(length > 1e-6f)) return p.normal_shading;
    return (p.back_side ? -n : n) / length;
}

struct Dielectric {
    Vec3f f0;
    float f90;
};

// KHR_materials_ior and KHR_materials_specular: reflectance at both ends of the angle.
Dielectric dielectric_of(const Material& m, const ShadePoint& point, const TextureStore& textures) noexcept
{
    const float root = (m.ior - 1) / (m.ior + 1);
    const float strength = m.specular * texel(m.specular_texture, point, textures).w;
    const Vec3f tint = m.specular_color * Vec3f(texel(m.specular_color_texture, point, textures));
    return {glm::min(root * root * tint, Vec3f(1)) * strength, strength};
}

void add_transmission(const Material& m, float metallic, float roughness, const ShadePoint& point, const TextureStore& textures,
                      Surface& s) noexcept
{
    const float share = m.transmission * texel(m.transmission_texture, point, textures).x * (1 - metallic);
    if (!(share > 0)) return;
    s.diffuse *= 1 - std::min(share, 1.0f);
    s.is_solid = m.thickness > 0 && m.ior > 1 + kLeastBend;
    if (s.is_solid) {
        // Light crosses a body's surface twice: straight through it is tinted once.
        s.transmission = share * Vec3f(std::sqrt(std::max(0.0f, s.base_color.x)), std::sqrt(std::max(0.0f, s.base_color.y)),
                                       std::sqrt(std::max(0.0f, s.base_color.z)));
        s.eta = point.back_side ? 1 / m.ior : m.ior;
        if (m.attenuation_distance > 0 && m.attenuation_distance < std::numeric_limits<float>::infinity())
            for (int c = 0; c < 3; ++c)
                s.absorption_inside[c] = -maths::log(std::clamp(m.attenuation_color[c], 1e-6f, 1.0f)) / m.attenuation_distance;
        return;
    }
    const Vec3f tint = share * s.base_color;
    if (roughness >= kClearRoughness) {
        s.transmission = tint;
        return;
    }
    const float cosine = std::max(0.0f, glm::dot(s.normal, s.to_eye));
    const float reflected = s.dielectric_f0 + (s.dielectric_f90 - s.dielectric_f0) * schlick(cosine);
    s.passes += s.opacity * tint * (1 - reflected);
}

}  // namespace

Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept
{
    const Material& m = *point.material;
    Surface s;
    s.position = point.position;
    s.self_distance = point.self_distance;
    s.to_eye = point.to_eye;
    s.normal_geometric = point.normal_geometric;
    s.normal = s.coat_normal = point.normal_shading;

    const Vec4f base = m.base_color * texel(m.base_color_texture, point, textures) * point.color;
    s.base_color = Vec3f(base);
    s.opacity = opacity_of(m, base.w * texel(m.alpha_texture, point, textures).x);
    s.passes = Vec3f(1 - s.opacity);
    s.unlit = m.unlit;
    if (s.unlit || s.opacity == 0) return s;
    s.normal = mapped_normal(m.normal_texture, m.normal_scale, point, textures);
    s.emission = m.emission == Vec3f(0) ? Vec3f(0) : m.emission * Vec3f(texel(m.emission_texture, point, textures));

    const Vec4f rough_metal = texel(m.metallic_roughness_texture, point, textures);
    const float metallic = std::clamp(m.metallic * rough_metal.z * texel(m.metallic_texture, point, textures).z, 0.0f, 1.0f);
    const float roughness = m.roughness * rough_metal.y * texel(m.roughness_texture, point, textures).y;
    s.alpha = lobe_width(roughness);
    s.diffuse = s.base_color * (1 - metallic);
    const Dielectric dielectric = dielectric_of(m, point, textures);
    s.dielectric_f0 = std::max({dielectric.f0.x, dielectric.f0.y, dielectric.f0.z});
    s.dielectric_f90 = dielectric.f90;
    s.f0 = dielectric.f0 * (1 - metallic) + s.base_color * metallic;
    s.f90 = dielectric.f90 * (1 - metallic) + metallic;
    if (m.transmission > 0) add_transmission(m, metallic, roughness, point, textures, s);

    if (m.clearcoat > 0) {
        s.coat = std::clamp(m.clearcoat * texel(m.clearcoat_texture, point, textures).x, 0.0f, 1.0f);
        s.coat_alpha = lobe_width(m.clearcoat_roughness * texel(m.clearcoat_roughness_texture, point, textures).y);
        s.coat_normal = mapped_normal(m.clearcoat_normal_texture, 1, point, textures);
        const float kept = 1 - s.coat * coat_albedo(std::max(0.0f, glm::dot(s.coat_normal, s.to_eye)), s.coat_alpha);
        s.emission *= kept;
        s.passes = Vec3f(1 - s.opacity) + (s.passes - Vec3f(1 - s.opacity)) * kept;
    }
    const bool reflects = s.f0 != Vec3f(0) || s.f90 != 0 || s.dielectric_f0 != 0 || s.dielectric_f90 != 0 || s.coat > 0;
    s.is_matte = !reflects && !s.is_solid && s.transmission == Vec3f(0);
    return s;
}

Vec3f passes_straight(const ShadePoint& point, const TextureStore& textures) noexcept
{
    return may_pass(*point.material) ? evaluate(point, textures).passes : Vec3f(0);
}

bool may_pass(const Material& m) noexcept
{
    const bool may_be_clear = m.roughness < kClearRoughness || m.metallic_roughness_texture || m.roughness_texture;
    return m.alpha_mode != AlphaMode::Opaque || (m.transmission > 0 && may_be_clear);
}

}  // namespace occam::shade
