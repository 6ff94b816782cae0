#include "shade/surface.h"

#include <algorithm>
#include <glm/common.hpp>

#include "scenegraph/material_limits.h"
#include "shade/albedo_table.h"
#include "shade/bump.h"
#include "shade/fresnel.h"
#include "shade/input_limits.h"
#include "shade/material_values.h"
#include "shade/sheen.h"

namespace occam::shade {
namespace {

float lobe_width(float roughness) noexcept
{
    const float r = std::clamp(roughness, 0.0f, 1.0f);
    return std::max(r * r, kMinAlpha);
}

float opacity_of(const Material& material, float alpha) noexcept
{
    switch (material.alpha_mode) {
        case AlphaMode::Opaque:
            break;
        case AlphaMode::Mask:
            return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
        case AlphaMode::Blend:
            return std::clamp(alpha, 0.0f, 1.0f);
    }
    return 1;
}

// The axes of a normal map, across the outward normal.
struct MapAxes {
    Vec3f right, up;
};

// Returns the axes of coordinates (s, t) after KHR_texture_transform: where s grows, and where t falls; both are zero where
// there are none. By the transform's inverse, dP/ds is cos / scale.x of dP/du and sin / scale.y of dP/dv. How long these are
// on the surface counts, too: a turned map is only square to its axes where its texels are squares.
MapAxes axes_of(const TextureUse& use, Vec3f outward, const ShadePoint& p) noexcept
{
    const MapTangent& uv = has_other_axes(*p.material, use) ? p.other_axes : p.axes;
    const float hand = (use.scale.x < 0) != (use.scale.y < 0) ? -1.0f : 1.0f;
    Vec3f right = use.scale.x < 0 ? -uv.along : uv.along;
    if (use.rotation != 0) {
        const float u = hand * use.scale.y * maths::cos(use.rotation), v = hand * use.scale.x * maths::sin(use.rotation);
        right = uv.along * (u + v * uv.v_axis.x) + glm::cross(outward, uv.along) * (v * uv.v_axis.y);
        const float length = glm::length(right);
        right = length > 0 && length < std::numeric_limits<float>::infinity() ? right / length : Vec3f(0);
    }
    return {right, glm::cross(outward, right) * (uv.sign * hand)};
}

// Returns the normal from a map (glTF 2.0, sec. 3.9.3), about the interpolated normal. A texel whose z is negative leads
// below the surface.
Vec3f mapped_normal(const TextureUse& use, Vec3f t, float scale, const ShadePoint& p) noexcept
{
    if (!use) return p.normal_shading;
    scale = std::clamp(scale, -kMaxNormalScale, kMaxNormalScale);
    const Vec3f outward = p.back_side ? -p.normal_shading : p.normal_shading;
    const MapAxes axes = axes_of(use, outward, p);
    if (axes.right == Vec3f(0)) return p.normal_shading;
    const Vec3f n = axes.right * (t.x * scale) + axes.up * (t.y * scale) + outward * t.z;
    const float length = glm::length(n);
    if (!(length > 1e-6f)) return p.normal_shading;
    return (p.back_side ? -n : n) / length;
}

// A reflected direction keeps at least this share of the cosine between the eye and the facet above the facet.
constexpr float kLeastLift = 0.25f;

// Returns the shading normal, tilted towards the eye as far as it takes for a mirror to reflect the eye's ray to above
// the facet. Rays that a normal map, or the interpolation over a coarse mesh, sends below it would be lost, and leave
// black rings on metals (Keller et al. 2017). A normal that turns away from the eye is tilted as one across the eye's ray
// is. So the normal is on the side of the eye, and on that of the facet. It lies between the eye and the lifted direction:
// where the eye is so low that these are nearly opposite, and rounding may turn the normal away, the facet's is taken.
Vec3f reflecting_normal(Vec3f normal, const ShadePoint& p) noexcept
{
    const Vec3f facet = p.normal_geometric;
    const float lift = kLeastLift * std::max(glm::dot(facet, p.to_eye), 0.0f);
    const float cosine = glm::dot(normal, p.to_eye);
    const Vec3f reflected = normal * (2 * std::max(cosine, 0.0f)) - p.to_eye;
    const float height = glm::dot(facet, reflected);
    if (cosine > 0 && height >= lift) return normal;
    const Vec3f along = reflected - facet * height;
    const float length = glm::length(along);
    if (!(length > 1e-6f)) return facet;
    const Vec3f lifted = along * (std::sqrt(1 - lift * lift) / length) + facet * lift;
    const Vec3f half = lifted + p.to_eye;
    const float half_length = glm::length(half);
    return glm::dot(half, p.to_eye) >= 0.5f * lift * half_length && half_length > 1e-6f ? half / half_length : facet;
}

struct Dielectric {
    Vec3f f0;
    float f90;
};

// Returns the reflectance at both ends of the angle, by KHR_materials_ior and KHR_materials_specular.
Dielectric dielectric_of(const Material& m, const MaterialValues& values) noexcept
{
    const float ior = std::min(m.ior, kMaxIor), root = (ior - 1) / (ior + 1);
    const float specular = std::clamp(values.specular, 0.0f, 1.0f);  // texels of floats may be beyond either
    return {glm::clamp(root * root * values.specular_color, 0.0f, 1.0f) * specular, specular};
}

// Notes the shares of which the layer is mixed, unless all of it is of one kind.
void note_mix(const Dielectric& dielectric, float dielectric_share, float metal_share, Surface& s) noexcept
{
    const bool is_dielectric = dielectric_share == 1 && metal_share == 0,
               is_metal = dielectric_share == 0 && metal_share == 1;
    s.is_mixed = !is_dielectric && !is_metal;
    s.dielectric_color = dielectric.f0;
    s.dielectric_share = dielectric_share;
    s.metal_share = metal_share;
}

// Handles a surface that is glass in part: the rest is metal and opaque dielectric, in their given proportion.
void mix_opaque_rest(const MaterialValues& values, float metallic, const Dielectric& dielectric, Surface& s) noexcept
{
    const float opaque = (1 - metallic) * (1 - std::min(values.transmission, 1.0f)), rest = opaque + metallic;
    if (!(rest > 0)) return;
    s.diffuse = s.base_color * (opaque / rest);
    s.f0 = (dielectric.f0 * opaque + s.base_color * metallic) / rest;
    s.f90 = (dielectric.f90 * opaque + metallic) / rest;
    note_mix(dielectric, opaque / rest, metallic / rest, s);
}

// Returns the tint at the surface of a body. Light crosses it twice, so one straight path through a body is tinted once.
Vec3f tint_of_crossing(Vec3f base_color) noexcept
{
    return Vec3f(std::sqrt(std::max(0.0f, base_color.x)), std::sqrt(std::max(0.0f, base_color.y)),
                 std::sqrt(std::max(0.0f, base_color.z)));
}

Vec3f absorption_in(const Material& m) noexcept
{
    Vec3f absorption(0);
    if (m.attenuation_distance > 0 && m.attenuation_distance < std::numeric_limits<float>::infinity())
        for (int c = 0; c < 3; ++c)
            absorption[c] = -maths::log(std::clamp(m.attenuation_color[c], 1e-6f, 1.0f)) / m.attenuation_distance;
    return absorption;
}

// Says what lies behind the surface. It depends on the material alone and not on its textures, so that all parts of the
// surface bound the same body.
void add_body(const Material& m, Surface& s) noexcept
{
    s.bounds_body = is_straight_body(m) || (m.thickness > 0 && m.ior > 1 + kLeastBend);
    if (s.bounds_body) s.absorption_inside = absorption_in(m);
}

// Handles the boundary of a body of the same index as the outside. However rough it is, it neither reflects nor bends light:
// only the share that is metal or an opaque dielectric scatters.
void add_straight_body(const MaterialValues& values, const Dielectric& dielectric, float share, Surface& s) noexcept
{
    const float metallic = std::clamp(values.metallic, 0.0f, 1.0f),
                opaque = (1 - metallic) * (1 - std::min(values.transmission, 1.0f));
    s.is_straight = true;
    s.transmittance += s.opacity * share * tint_of_crossing(s.base_color);
    s.diffuse = s.base_color * opaque;
    s.f0 = dielectric.f0 * opaque + s.base_color * metallic;
    s.f90 = dielectric.f90 * opaque + metallic;
    note_mix(dielectric, opaque, metallic, s);
    if (!(opaque > 0)) s.dielectric_f0 = s.dielectric_f90 = 0;  // there is no base under it
}

void add_transmission(const Material& m, const MaterialValues& values, const Dielectric& dielectric, bool back_side,
                      Surface& s) noexcept
{
    const float metallic = std::clamp(values.metallic, 0.0f, 1.0f);
    const float transmission = std::min(values.transmission, 1.0f), share = transmission * (1 - metallic);
    if (!(share > 0)) return;
    if (is_straight_body(m)) return add_straight_body(values, dielectric, share, s);
    s.is_solid = s.bounds_body;
    if (s.is_solid) {
        s.solid_share = share;
        mix_opaque_rest(values, metallic, dielectric, s);
        s.transmission = tint_of_crossing(s.base_color);
        const float ior = std::min(m.ior, kMaxIor);
        s.eta = back_side ? 1 / ior : ior;
        return;
    }
    s.diffuse *= 1 - transmission;
    const Vec3f tint = share * s.base_color;
    if (values.roughness >= kClearRoughness) {
        s.transmission = tint;
        return;
    }
    const float cosine = std::max(0.0f, glm::dot(s.normal, s.to_eye));
    const float reflected = s.dielectric_f0 + (s.dielectric_f90 - s.dielectric_f0) * schlick(cosine);
    s.transmittance += s.opacity * tint * (1 - reflected);
}

// Returns the share of the surface that is a pane, or the boundary of a body that bends light.
float glass_share(const Material& m, const MaterialValues& values) noexcept
{
    if (!(m.transmission > 0) || is_straight_body(m)) return 0;
    return std::min(values.transmission, 1.0f) * (1 - std::clamp(values.metallic, 0.0f, 1.0f));
}

// Applies KHR_materials_anisotropy: the width along the strokes grows to 1 with the square of the strength. Glass stays
// isotropic: its two lobes share one distribution. So strokes fade until a thirty-second of the surface is glass: with few
// strokes that much loses no light to speak of, and a metal keeps its strokes if rounding says that it is glass in part.
void add_anisotropy(const Material& m, const MaterialValues& values, const ShadePoint& p, Surface& s) noexcept
{
    constexpr float kMostGlass = 1.0f / 32;
    const float of_strokes = 1 - glass_share(m, values) / kMostGlass;
    const float strength = std::clamp(m.anisotropy * values.anisotropy.z, 0.0f, 1.0f) * of_strokes;
    if (!(strength > 0)) return;
    const float c = maths::cos(m.anisotropy_rotation), si = maths::sin(m.anisotropy_rotation);
    const float x = values.anisotropy.x, y = values.anisotropy.y;
    const MapAxes axes = axes_of(m.anisotropy_texture, p.back_side ? -p.normal_shading : p.normal_shading, p);
    const Vec3f strokes = axes.right * (c * x - si * y) + axes.up * (si * x + c * y);
    const Vec3f across = strokes - s.normal * glm::dot(strokes, s.normal);
    const float length = glm::length(across);
    if (!(length > 1e-6f)) return;
    s.tangent = across / length;
    s.alpha_across = s.alpha;
    s.alpha_along = s.alpha + (1 - s.alpha) * strength * strength;
    s.alpha = std::sqrt(s.alpha_along * s.alpha_across);
}

void add_sheen(const MaterialValues& values, Surface& s) noexcept
{
    if (s.sheen == Vec3f(0)) return;
    s.sheen_alpha = sheen_width(values.sheen_roughness);
    const float kept = sheen_for_eye(s, std::max(0.0f, glm::dot(s.normal, s.to_eye))).below;
    s.transmittance = Vec3f(1 - s.opacity) + (s.transmittance - Vec3f(1 - s.opacity)) * kept;
}

void set_place(const ShadePoint& point, Surface& s) noexcept
{
    s.position = point.position;
    s.start_point = point.position + Vec3d(point.to_start);
    s.start_normal = point.start_normal;
    s.self_distance = point.self_distance;
    s.to_eye = point.to_eye;
    s.normal_geometric = point.normal_geometric;
    s.normal = s.coat_normal = point.normal_shading;
}

// Returns whether the layer reflects anything at all.
bool has_layer(const Surface& s) noexcept { return s.f0 != Vec3f(0) || s.f90 != 0; }

// Returns whether the material's values are the same everywhere, and whether all that evaluate() makes of them, but for the
// normal, is the same for any eye.
bool is_plain(const Material& m) noexcept
{
    for (const TextureUse* use :
         {&m.base_color_texture, &m.metallic_roughness_texture, &m.roughness_texture, &m.metallic_texture,
          &m.glossiness_texture, &m.emission_texture, &m.normal_texture, &m.bump_texture, &m.alpha_texture,
          &m.specular_texture, &m.specular_color_texture, &m.transmission_texture, &m.sheen_color_texture,
          &m.anisotropy_texture, &m.clearcoat_texture})
        if (*use) return false;
    return !(m.transmission > 0) && !(m.anisotropy > 0) && m.sheen_color == Vec3f(0) && !(m.clearcoat > 0);
}

}  // namespace

void PlainSurfaces::fill(Entry& entry, const Material& material, const TextureStore& textures) noexcept
{
    entry.material = &material;
    entry.is_plain = is_plain(material);
    if (!entry.is_plain) return;
    ShadePoint anywhere;
    anywhere.material = &material;
    entry.surface = evaluate(anywhere, textures);
}

Surface evaluate(const ShadePoint& point, const TextureStore& textures, PlainSurfaces& known) noexcept
{
    const Surface* const plain = point.phase_one || point.color != Vec4f(1) ? nullptr
                                                                            : known.find(*point.material, textures);
    // There is one object to return, so that it is made where the caller wants it.
    Surface s = plain ? *plain : evaluate(point, textures);
    if (!plain) return s;
    set_place(point, s);
    if (!s.unlit && s.opacity != 0 && has_layer(s)) s.normal = reflecting_normal(s.normal, point);
    return s;
}

Surface evaluate(const ShadePoint& point, const TextureStore& textures) noexcept
{
    const Material& m = *point.material;
    Surface s;
    set_place(point, s);

    MaterialValues values = point.phase_one ? unpack(m, point.phase_one) : MaterialValues(m);
    if (!point.phase_one || m.alpha_mode == AlphaMode::Mask) values.look_up_color(m, point.texture, textures);
    const Vec4f base = values.base_color * point.color;
    s.base_color = Vec3f(base);
    s.opacity = opacity_of(m, base.w * values.alpha);
    s.transmittance = Vec3f(1 - s.opacity);
    s.unlit = m.unlit;
    s.base_color = s.unlit ? limited(s.base_color) : glm::min(limited(s.base_color), Vec3f(1));
    if (s.unlit) return s;
    const bool is_hole = m.alpha_mode == AlphaMode::Mask && s.opacity == 0;
    if (m.transmission > 0 && !is_hole) add_body(m, s);
    if (s.opacity == 0) return s;
    if (!point.phase_one) {
        values.look_up_rest(m, point.texture, textures);
    }
    s.normal = mapped_normal(m.normal_texture, values.normal, m.normal_scale, point);
    if (m.bump_texture) {
        const Vec3f slope = point.phase_one ? point.u_gradient * values.rise.x + point.v_gradient * values.rise.y
                                            : bump_slope(point, textures);
        if (slope != Vec3f(0)) s.normal = bumped_normal(s.normal, slope, point);
    }
    s.emission = limited(values.emission);

    const float metallic = std::clamp(values.metallic, 0.0f, 1.0f);
    s.alpha = lobe_width(values.roughness);
    s.diffuse = s.base_color * (1 - metallic);
    const Dielectric dielectric = dielectric_of(m, values);
    s.dielectric_f0 = std::max({dielectric.f0.x, dielectric.f0.y, dielectric.f0.z});
    s.dielectric_f90 = dielectric.f90;
    s.f0 = dielectric.f0 * (1 - metallic) + s.base_color * metallic;
    s.f90 = dielectric.f90 * (1 - metallic) + metallic;
    note_mix(dielectric, 1 - metallic, metallic, s);
    if (m.sheen_color != Vec3f(0)) s.sheen = glm::clamp(values.sheen_color, 0.0f, 1.0f);
    // Each lobe that depends on the eye is on its side.
    const bool has_facets = has_layer(s) || s.sheen != Vec3f(0) || (m.transmission > 0 && !is_straight_body(m));
    if (has_facets) s.normal = reflecting_normal(s.normal, point);
    if (m.transmission > 0) add_transmission(m, values, dielectric, point.back_side, s);

    if (m.anisotropy > 0) add_anisotropy(m, values, point, s);
    add_sheen(values, s);

    if (m.clearcoat > 0) {
        s.coat = std::clamp(values.coat, 0.0f, 1.0f);
        s.coat_alpha = lobe_width(values.coat_roughness);
        s.coat_normal = reflecting_normal(
            mapped_normal(m.clearcoat_normal_texture, values.coat_normal, m.clearcoat_normal_scale, point), point);
        const float kept = 1 - s.coat * coat_albedo(std::max(0.0f, glm::dot(s.coat_normal, s.to_eye)), s.coat_alpha);
        s.emission *= kept;
        s.transmittance = Vec3f(1 - s.opacity) + (s.transmittance - Vec3f(1 - s.opacity)) * kept;
    }
    const bool reflects = has_layer(s) || s.dielectric_f0 != 0 || s.dielectric_f90 != 0 || s.coat > 0 || s.sheen != Vec3f(0);
    s.is_matte = !reflects && !s.is_solid && s.transmission == Vec3f(0);
    return s;
}

bool is_hole(const Material& m, const lod::VertexToShade& at, Vec4f color, const TextureStore& textures) noexcept
{
    if (m.alpha_mode != AlphaMode::Mask) return false;
    MaterialValues values(m);
    values.look_up_mask(m, at, textures);
    return opacity_of(m, (values.base_color * color).w * values.alpha) == 0;
}

StraightPass passes_straight(const ShadePoint& point, const TextureStore& textures) noexcept
{
    if (!may_pass(*point.material)) return {};
    const Surface s = evaluate(point, textures);
    return {s.transmittance, s.bounds_body, s.absorption_inside};
}

float ambient_share(const ShadePoint& point, const TextureStore& textures) noexcept
{
    const Material& m = *point.material;
    if (m.unlit || !m.occlusion_texture) return 1;
    MaterialValues values = point.phase_one ? unpack(m, point.phase_one) : MaterialValues(m);
    if (!point.phase_one) values.look_up_occlusion(m, point.texture, textures);
    return values.occlusion;
}

}  // namespace occam::shade
