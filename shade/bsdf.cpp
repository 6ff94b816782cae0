#include "shade/bsdf.h"

#include <algorithm>

#include "base/luminance.h"
#include "shade/sheen.h"
#include "shade/stroke_albedo.h"
#include "shade/transmission.h"

namespace occam::shade {
namespace {

struct Angles {
    float n_l, n_v, n_h, v_h, sin2_h;

    Angles(Vec3f normal, Vec3f to_eye, Vec3f to_light) noexcept
    {
        const Vec3f half = to_eye + to_light;
        const float length = glm::length(half);
        const Vec3f h = length > 0 ? half / length : normal;
        const Vec3f across = glm::cross(normal, h);
        n_l = glm::dot(normal, to_light);
        n_v = eye_cosine(normal, to_eye);
        n_h = glm::dot(normal, h);
        v_h = glm::dot(to_eye, h);
        sin2_h = glm::dot(across, across);
    }
};

// Describes the layer's lobe of a surface with brush strokes, in axes along the direction of the strokes.
struct Strokes {
    Vec3f x, y, z;
    Widths widths;

    explicit Strokes(const Surface& s) noexcept
        : x(s.tangent), y(glm::cross(s.normal, s.tangent)), z(s.normal), widths{s.alpha_along, s.alpha_across}
    {
    }
    Vec3f local(Vec3f v) const noexcept { return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)}; }
    Vec3f local_eye(Vec3f v) const noexcept
    {
        Vec3f eye = local(v);
        eye.z = std::max(eye.z, 1e-4f);
        return glm::normalize(eye);
    }
    float lobe(const Surface& s, Vec3f to_light) const noexcept
    {
        const Vec3f h = local(glm::normalize(s.to_eye + to_light));
        return ggx_density(h, widths) * ggx_visibility(local(to_light), local_eye(s.to_eye), widths);
    }
    float density(const Surface& s, Vec3f to_light) const noexcept
    {
        const Vec3f half = s.to_eye + to_light;
        const float length = glm::length(half);
        return length > 0 ? visible_density_over_cosine(local_eye(s.to_eye), local(half / length), widths) / 4 : 0;
    }
    Vec3f sample(Vec3f to_eye, Vec2f square) const noexcept
    {
        const Vec3f h = visible_normal(local_eye(to_eye), widths, square);
        return x * h.x + y * h.y + z * h.z;
    }
};

bool has_strokes(const Surface& s) noexcept { return s.tangent != Vec3f(0); }

LayerOf<float> layer_of(const Surface& s, AlbedoTable::Row row) noexcept
{
    LayerOf<float> of;
    of.f0 = s.dielectric_f0;
    of.f90 = s.dielectric_f90;
    complete(of, mix_of(s), AlbedoTable::instance().mean(row));
    return of;
}

LayerAlbedo albedo_of_eye(const Surface& s, float n_v, AlbedoTable::Row row) noexcept
{
    if (!has_strokes(s)) return AlbedoTable::instance().at(n_v, row);
    const Strokes strokes(s);
    return stroke_albedo(strokes.local_eye(s.to_eye), strokes.widths);
}

// Returns the multiple scattering through a rough pane: what is neither reflected nor transmitted by single scattering.
float multiple_through(const LayerOf<float>& of, LayerAlbedo eye, LayerAlbedo light) noexcept
{
    const float lost = std::max(0.0f, 1 - eye.sum()) * std::max(0.0f, 1 - light.sum());
    return of.mean < 1 ? (1 - of.base_multiple) * lost / ((1 - of.mean) * kPi) : 0;
}

// Returns the share of the light transmitted by a pane that single scattering transmits.
float single_share(const LayerOf<float>& of, LayerAlbedo eye) noexcept
{
    const float single = (1 - of.f0) * eye.f0 + (1 - of.f90) * eye.f90, all = through(of, eye);
    return all > 0 ? std::clamp(single / all, 0.0f, 1.0f) : 1;
}

void add_opaque(const SurfaceForEye& of, float below, LobeShares& to) noexcept
{
    const Surface& s = of.surface;
    const float to_base = through(of.layer, of.eye);
    to.layer = below * (luminance(s.f0) * of.eye.f0 + s.f90 * of.eye.f90);
    to.diffuse = below * (to_base * luminance(s.diffuse));
    to.multiple = below * (luminance(of.layer.multiple) * std::max(0.0f, 1 - of.eye.sum()));
    if (s.is_solid) return;
    to.pane_multiple = below * to_base * luminance(s.transmission);
    to.pane = to.pane_multiple * single_share(of.layer, of.eye);
    to.pane_multiple -= to.pane;
}

LobeShares shares_of(const SurfaceForEye& of, float n_v, float coat_reflects) noexcept
{
    const Surface& s = of.surface;
    LobeShares to;
    to.coat = coat_reflects;
    float below = 1 - to.coat;
    to.diffuse = 0;
    if (s.is_solid) {
        const float f = fresnel_dielectric(n_v, s.eta);
        to.body = below * s.solid_share * (f + (1 - f) * luminance(s.transmission));
        below *= 1 - s.solid_share;
    }
    if (below > 0) add_opaque(of, below, to);
    if (s.sheen != Vec3f(0)) {
        for (float* share : {&to.diffuse, &to.multiple, &to.layer, &to.pane, &to.pane_multiple, &to.body})
            *share *= of.sheen.below;
        to.sheen = (1 - to.coat) * luminance(s.sheen) * of.sheen.reflects;
    }
    const float sum = to.diffuse + to.multiple + to.layer + to.coat + to.pane + to.pane_multiple + to.body + to.sheen;
    if (!(sum > 0)) return {};
    for (float* share : {&to.diffuse, &to.multiple, &to.layer, &to.coat, &to.pane, &to.pane_multiple, &to.body, &to.sheen})
        *share /= sum;
    return to;
}

// Returns the share of a lobe that is left towards the facet's horizon. It is like terminator(), but reaches 1 already at
// the lowest direction to which a reflecting normal (evaluate()) reflects the eye.
float lobe_terminator(Vec3f facet, Vec3f normal, float n_l, Vec3f to_light) noexcept
{
    const float side = glm::dot(facet, to_light), along = std::max(kSteepLobe * n_l * glm::dot(facet, normal), 1e-6f);
    return faded(side, along);
}

// Returns the reflection below the coat of what is opaque or a pane: f times the cosine, with the light on the eye's
// side and above the horizon.
// lobe    density and visibility of the layer's microfacets
// light   albedo of the layer towards the light
Vec3f reflected(const SurfaceForEye& of, Vec3f to_light, const Angles& a, float lobe, LayerAlbedo light) noexcept
{
    const Surface& s = of.surface;
    const Vec3f mirror = reflectance(s.f0, s.f90, schlick(a.v_h)) * lobe + multiple_lobe(of.layer, of.eye, light);
    const Vec3f base = s.diffuse * (into_base(of.layer, of.eye, light) / kPi);
    return mirror * (a.n_l * lobe_terminator(s.normal_geometric, s.normal, a.n_l, to_light)) +
           base * (a.n_l * terminator(s, a.n_l, to_light));
}

Vec3f reflected(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    const Angles a(s.normal, s.to_eye, to_light);
    if (!(a.n_l > 0)) return Vec3f(0);
    const float lobe = has_strokes(s)
                           ? Strokes(s).lobe(s, to_light)
                           : ggx_density(a.n_h, a.sin2_h, s.alpha) * ggx_visibility(a.n_l, a.n_v, of.root, s.alpha);
    return reflected(of, to_light, a, lobe, AlbedoTable::instance().at(a.n_l, of.row));
}

// Returns the transmission of a pane below the coat: f times the cosine.
Vec3f through_rough_pane(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    Vec3f f(0);
    for_directions_of_pane(s, to_light, [&](Vec3f direction) {
        const float n_l = -glm::dot(s.normal, direction);
        if (!(n_l > 0)) return;
        const LayerAlbedo light = AlbedoTable::instance().at(n_l, of.row);
        f += pane_transmission(s, direction) + s.transmission * (multiple_through(of.layer, of.eye, light) * n_l);
    });
    return f;
}

Vec3f reflected(Vec3f to_eye, Vec3f h) noexcept { return glm::normalize(h * (2 * glm::dot(to_eye, h)) - to_eye); }

float lobe_density(Vec3f normal, Vec3f to_eye, Vec3f to_light, float alpha) noexcept
{
    const Angles a(normal, to_eye, to_light);
    return visible_density_over_cosine(a.n_v, a.n_h, a.sin2_h, alpha) / 4;
}

// Returns the density of directions of that cosine which follow the light that bounces several times.
float density_of_multiple(const SurfaceForEye& of, float cosine) noexcept
{
    return multiple_density(AlbedoTable::instance().at(cosine, of.row), cosine, of.lost);
}

Vec3f coated(const SurfaceForEye& of, Vec3f below, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    const Angles a(s.coat_normal, s.to_eye, to_light);
    // Everything below the coat receives what the coat does not reflect to the eye. All light is accounted for, whatever the
    // base does with it, and the function is not reciprocal.
    below *= of.below_coat;
    if (!(a.n_l > 0) || !(glm::dot(s.normal_geometric, to_light) > 0)) return below;
    const float fresnel = kCoatF0 + (1 - kCoatF0) * schlick(a.v_h);
    const float lobe = ggx_density(a.n_h, a.sin2_h, s.coat_alpha) * ggx_visibility(a.n_l, a.n_v, s.coat_alpha);
    return below +
           Vec3f(s.coat * fresnel * lobe * a.n_l * lobe_terminator(s.normal_geometric, s.coat_normal, a.n_l, to_light));
}

}  // namespace

void SurfaceForEye::set() noexcept
{
    const Surface& s = surface;
    const float n_v = eye_cosine(s.normal, s.to_eye);
    row = AlbedoTable::row_of(has_strokes(s) ? s.alpha_along : s.alpha);
    layer = layer_of(s, row);
    eye = albedo_of_eye(s, n_v, row);
    lost = AlbedoTable::instance().lost(row);
    masking = ggx_masking_over_cosine(n_v, s.alpha);
    root = ggx_root(n_v, s.alpha);
    is_plain = !s.is_solid && !has_strokes(s) && !(s.coat > 0) && s.sheen == Vec3f(0) && s.transmission == Vec3f(0);
    const float coat_reflects = s.coat > 0 ? s.coat * coat_albedo(eye_cosine(s.coat_normal, s.to_eye), s.coat_alpha) : 0;
    below_coat = 1 - coat_reflects;
    if (s.sheen != Vec3f(0)) sheen = sheen_for_eye(s, n_v);
    shares = shares_of(*this, n_v, coat_reflects);
}

float scatter_density(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    const LobeShares& share = of.shares;
    const float n_l = glm::dot(s.normal, to_light);
    float density = share.diffuse * std::max(n_l, 0.0f) / kPi;
    if (share.layer > 0)
        density += share.layer *
                   (has_strokes(s) ? Strokes(s).density(s, to_light) : lobe_density(s.normal, s.to_eye, to_light, s.alpha));
    if (share.multiple > 0 && n_l > 0) density += share.multiple * density_of_multiple(of, n_l);
    if (share.coat > 0) density += share.coat * lobe_density(s.coat_normal, s.to_eye, to_light, s.coat_alpha);
    if (share.pane > 0 || share.pane_multiple > 0)
        for_directions_of_pane(s, to_light, [&](Vec3f direction) {
            if (share.pane > 0) density += share.pane * pane_density(s, direction);
            if (share.pane_multiple > 0)
                density += share.pane_multiple * density_of_multiple(of, -glm::dot(s.normal, direction));
        });
    if (share.body > 0) density += share.body * body_density(s, to_light);
    if (n_l > 0) density += share.sheen * kHemisphereDensity;
    return density;
}

Vec3f scatter_of_lobes(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    const Surface& s = of.surface;
    const float side = glm::dot(s.normal_geometric, to_light);
    Vec3f f(0);
    if (s.is_solid) f = body_scattering(s, to_light) * s.solid_share;
    if (side > 0 && (!s.is_solid || s.solid_share < 1)) f += reflected(of, to_light) * (s.is_solid ? 1 - s.solid_share : 1);
    else if (side < 0 && !s.is_solid && s.transmission != Vec3f(0)) f = through_rough_pane(of, to_light);
    if (s.sheen != Vec3f(0)) f = sheened(s, of.sheen, f, to_light);
    return s.coat > 0 ? coated(of, f, to_light) : f;
}

ScatterWithDensity scatter_with_density(const SurfaceForEye& of, Vec3f to_light) noexcept
{
    if (!of.is_plain) return {scatter(of, to_light), scatter_density(of, to_light)};
    const Surface& s = of.surface;
    const Angles a(s.normal, s.to_eye, to_light);
    const float normals = ggx_density(a.n_h, a.sin2_h, s.alpha);
    ScatterWithDensity both;
    both.density = of.shares.diffuse * std::max(a.n_l, 0.0f) / kPi;
    if (of.shares.layer > 0) both.density += of.shares.layer * ((a.n_h > 0 ? of.masking * normals : 0) / 4);
    const bool is_lit = glm::dot(s.normal_geometric, to_light) > 0;
    if (!(a.n_l > 0) || !(is_lit || of.shares.multiple > 0)) return both;
    const LayerAlbedo light = AlbedoTable::instance().at(a.n_l, of.row);
    if (of.shares.multiple > 0) both.density += of.shares.multiple * multiple_density(light, a.n_l, of.lost);
    if (is_lit) both.light = reflected(of, to_light, a, normals * ggx_visibility(a.n_l, a.n_v, of.root, s.alpha), light);
    return both;
}

float peak_density(const Surface& s) noexcept
{
    if (s.transmission != Vec3f(0)) return std::numeric_limits<float>::infinity();
    float peak = 1 / kPi;
    if (s.is_matte) return peak;
    // A GGX lobe is densest about the reflected direction, where the microfacet normal is the surface normal.
    const auto include = [&](Vec3f normal, float alpha) {
        peak = std::max(peak, visible_density_over_cosine(eye_cosine(normal, s.to_eye), 1, 0, alpha) / 4);
    };
    // A lobe with two widths is flatter than a round one of the narrower width.
    include(s.normal, has_strokes(s) ? s.alpha_across : s.alpha);
    if (s.coat > 0) include(s.coat_normal, s.coat_alpha);
    return peak;
}

ScatterSample sample_scatter(const SurfaceForEye& of, float choice, Vec2f square) noexcept
{
    const Surface& s = of.surface;
    const LobeShares& share = of.shares;
    const ShadingFrame axes(s.normal);
    // Chooses the lobe whose interval of [0, 1) holds the choice; what is left of the choice is rescaled to a number in
    // [0, 1).
    const auto is_chosen = [&choice](float chance) {
        if (choice < chance) {
            choice /= chance;
            return true;
        }
        choice -= chance;
        return false;
    };
    ScatterSample out;
    if (is_chosen(share.diffuse)) {
        out.direction = axes.to_world(cosine_direction(square));
    } else if (is_chosen(share.multiple)) {
        out.direction = axes.to_world(multiple_direction(square, of.row));
    } else if (is_chosen(share.sheen)) {
        out.direction = axes.to_world(hemisphere_direction(square));
    } else if (is_chosen(share.layer)) {
        out.lobe = Lobe::Layer;
        out.alpha = s.alpha;
        out.direction = reflected(
            s.to_eye, has_strokes(s) ? Strokes(s).sample(s.to_eye, square) : seen_normal(axes, s.to_eye, s.alpha, square));
    } else if (is_chosen(share.body)) {
        out.alpha = s.alpha;
        out.direction = through_body(s, seen_normal(axes, s.to_eye, s.alpha, square), choice);
        out.lobe = glm::dot(s.normal_geometric, out.direction) < 0 ? Lobe::Transmission : Lobe::Layer;
    } else if (is_chosen(share.pane)) {
        out.lobe = Lobe::Transmission;
        out.alpha = s.alpha;
        out.direction = through_pane(s, seen_normal(axes, s.to_eye, s.alpha, square));
    } else if (is_chosen(share.pane_multiple)) {
        out.lobe = Lobe::Transmission;
        out.direction = behind_facet(s, -axes.to_world(multiple_direction(square, of.row)));
    } else if (share.coat > 0) {
        out.lobe = Lobe::Coat;
        out.alpha = s.coat_alpha;
        out.direction = reflected(s.to_eye, seen_normal(ShadingFrame(s.coat_normal), s.to_eye, s.coat_alpha, square));
    }
    if (out.direction == Vec3f(0)) return out;
    const ScatterWithDensity both = scatter_with_density(of, out.direction);
    out.density = both.density;
    if (out.density > 0 && out.density < std::numeric_limits<float>::infinity()) out.weight = both.light / out.density;
    return out;
}

}  // namespace occam::shade
