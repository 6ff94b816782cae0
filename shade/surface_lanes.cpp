#include "shade/surface_lanes.h"

#include <limits>

namespace occam::shade {
namespace {

// Does what luminance() does.
vfloat luminances(const VecLanes& c) noexcept { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

// Does what visible_normal_of() does, for a point of the disc.
VecLanes visible_normals(const VecLanes& eye, vfloat alpha, vfloat px, vfloat py) noexcept
{
    const vfloat zero = 0.0f, one = 1.0f;
    const VecLanes stretched = normalized({alpha * eye.x, alpha * eye.y, eye.z});
    const vfloat flat2 = stretched.x * stretched.x + stretched.y * stretched.y, flat = sqrt(flat2);
    const VecLanes t1 = select(flat2 > zero, VecLanes{-stretched.y / flat, stretched.x / flat, zero / flat},
                               VecLanes{one, zero, zero});
    const VecLanes t2 = cross(stretched, t1);
    const vfloat s = 0.5f * (1 + stretched.z);
    const vfloat y = (1 - s) * sqrt(max(1 - px * px, zero)) + s * py;
    const vfloat up = sqrt(max(1 - px * px - y * y, zero));
    const VecLanes h = t1 * px + t2 * y + stretched * up;
    return normalized({alpha * h.x, alpha * h.y, max(h.z, vfloat(1e-6f))});
}

}  // namespace

// Does what Angles of shade/bsdf.cpp does.
struct SurfaceLanes::Angles {
    vfloat n_l, n_h, v_h, sin2_h;

    Angles(const VecLanes& normal, const VecLanes& to_eye, const VecLanes& to_light) noexcept
    {
        const VecLanes half = to_eye + to_light;
        const vfloat size = length(half);
        const VecLanes h = select(size > vfloat(0.0f), divided(half, size), normal), across = cross(normal, h);
        n_l = dot(normal, to_light);
        n_h = dot(normal, h);
        v_h = dot(to_eye, h);
        sin2_h = dot(across, across);
    }
};

void SurfaceLanes::set(int lane, const Surface& s) noexcept
{
    normal_.set(lane, s.normal);
    geometric_.set(lane, s.normal_geometric);
    to_eye_.set(lane, s.to_eye);
    diffuse_.set(lane, s.diffuse);
    f0_.set(lane, s.f0);
    f90_.of[lane] = s.f90;
    const LayerMixOf<float> mix = mix_of(s);
    mix_f0_.set(lane, mix.f0);
    mix_f90_.of[lane] = mix.f90;
    mix_share_.of[lane] = mix.share;
    mix_metal_f0_.set(lane, mix.metal_f0);
    mix_metal_share_.of[lane] = mix.metal_share;
    alpha_.of[lane] = s.alpha;
    dielectric_f0_.of[lane] = s.dielectric_f0;
    dielectric_f90_.of[lane] = s.dielectric_f90;
    coat_normal_.set(lane, s.coat_normal);
    coat_.of[lane] = s.coat;
    coat_alpha_.of[lane] = s.coat_alpha;
    has_coat_ |= s.coat > 0;
}

// A matte surface has a layer that reflects nothing.
void SurfaceLanes::complete() noexcept
{
    const AlbedoTable& table = AlbedoTable::instance();
    const vfloat alpha = alpha_.lanes(), f90 = f90_.lanes(), zero = 0.0f;
    const VecLanes f0 = f0_.lanes();
    n_v_ = clamp(dot(normal_.lanes(), to_eye_.lanes()), vfloat(1e-4f), vfloat(1.0f));
    row_ = AlbedoTable::row_of(alpha);
    layer_.f0 = dielectric_f0_.lanes();
    layer_.f90 = dielectric_f90_.lanes();
    shade::complete(layer_,
                    LayerMixOf<vfloat>{mix_f0_.lanes(), mix_f90_.lanes(), mix_share_.lanes(), mix_metal_f0_.lanes(),
                                       mix_metal_share_.lanes()},
                    table.mean(row_));
    eye_ = table.at(n_v_, row_);
    lost_ = table.lost(row_);
    masking_ = ggx_masking_over_cosine(n_v_, alpha);
    root_ = ggx_root(n_v_, alpha);
    vfloat coat = zero;
    if (has_coat_) {
        coat_n_v_ = clamp(dot(coat_normal_.lanes(), to_eye_.lanes()), vfloat(1e-4f), vfloat(1.0f));
        const LayerAlbedoOf<vfloat> e = table.at(coat_n_v_, AlbedoTable::row_of(coat_alpha_.lanes()));
        coat = select(coat_.lanes() > zero, coat_.lanes() * (kCoatF0 * e.f0 + e.f90), zero);
    }
    below_coat_ = 1 - coat;
    const vfloat layer = below_coat_ * (luminances(f0) * eye_.f0 + f90 * eye_.f90);
    const vfloat base = below_coat_ * (through(layer_, eye_) * luminances(diffuse_.lanes()));
    const vfloat multiple = below_coat_ * (luminances(layer_.multiple) * max(1 - eye_.sum(), zero));
    const vfloat sum = base + multiple + layer + coat;
    const vmask is_any = sum > zero;
    share_diffuse_ = select(is_any, base / sum, vfloat(1.0f));
    share_multiple_ = select(is_any, multiple / sum, zero);
    share_layer_ = select(is_any, layer / sum, zero);
    share_coat_ = select(is_any, coat / sum, zero);
}

vfloat SurfaceLanes::peak_density() const noexcept
{
    const vfloat zero = 0.0f, one = 1.0f, diffuse = 1 / kPi;
    const vmask is_matte = is_black(f0_.lanes()) & (f90_.lanes() == zero) & (layer_.f0 == zero) & (layer_.f90 == zero);
    const vfloat of_base = select(is_matte & !(coat_.lanes() > zero), diffuse,
                                  max(masking_ * ggx_density(one, zero, alpha_.lanes()) / 4, diffuse));
    if (!has_coat_) return of_base;
    const vfloat coat_alpha = coat_alpha_.lanes();
    const vfloat of_coat = ggx_masking_over_cosine(coat_n_v_, coat_alpha) * ggx_density(one, zero, coat_alpha) / 4;
    return select(coat_.lanes() > zero, max(of_coat, of_base), of_base);
}

SurfaceLanes::Scattering SurfaceLanes::scatter_with_density(const VecLanes& to_light) const noexcept
{
    const VecLanes normal = normal_.lanes(), geometric = geometric_.lanes(), to_eye = to_eye_.lanes();
    const vfloat alpha = alpha_.lanes(), zero = 0.0f, tiny = 1e-6f;
    const Angles a(normal, to_eye, to_light);
    const vfloat side = dot(geometric, to_light), normals = ggx_density(a.n_h, a.sin2_h, alpha);

    Scattering out;
    out.density = share_diffuse_ * max(zero, a.n_l) / kPi +
                  share_layer_ * (select(a.n_h > zero, masking_ * normals, zero) / 4);
    const vfloat lobe = normals * ggx_visibility(a.n_l, n_v_, root_, alpha);
    const LayerAlbedoOf<vfloat> light = AlbedoTable::instance().at(a.n_l, row_);
    out.density = out.density + share_multiple_ * multiple_density(light, a.n_l, lost_);
    const VecLanes mirror = reflectance(f0_.lanes(), f90_.lanes(), schlick(a.v_h)) * lobe +
                            multiple_lobe(layer_, eye_, light);
    const VecLanes base = diffuse_.lanes() * (into_base(layer_, eye_, light) / kPi);
    const vfloat facing = dot(geometric, normal);
    const VecLanes f = mirror * (a.n_l * faded(side, max(tiny, kSteepLobe * a.n_l * facing))) +
                       base * (a.n_l * faded(side, max(tiny, a.n_l * facing)));
    out.light = select((a.n_l > zero) & (side > zero), f, all_channels(zero));
    if (has_coat_) add_coat(to_light, side, out);
    return out;
}

void SurfaceLanes::add_coat(const VecLanes& to_light, vfloat side, Scattering& to) const noexcept
{
    const vfloat alpha = coat_alpha_.lanes(), zero = 0.0f;
    const VecLanes normal = coat_normal_.lanes();
    const Angles a(normal, to_eye_.lanes(), to_light);
    const vfloat normals = ggx_density(a.n_h, a.sin2_h, alpha);
    to.density = to.density +
                 share_coat_ * (select(a.n_h > zero, ggx_masking_over_cosine(coat_n_v_, alpha) * normals, zero) / 4);
    const VecLanes below = to.light * below_coat_;
    const vfloat fresnel = kCoatF0 + (1 - kCoatF0) * schlick(a.v_h);
    const vfloat lobe = normals * ggx_visibility(a.n_l, coat_n_v_, ggx_root(coat_n_v_, alpha), alpha);
    const vfloat along = max(vfloat(1e-6f), kSteepLobe * a.n_l * dot(geometric_.lanes(), normal));
    const vfloat coat = coat_.lanes() * fresnel * lobe * a.n_l * faded(side, along);
    to.light = select((a.n_l > zero) & (side > zero), below + all_channels(coat), below);
}

LightSampleLanes SurfaceLanes::test_of(const LightSampleLanes& sample, vfloat light_count,
                                       vfloat scatter_count) const noexcept
{
    const Scattering f = scatter_with_density(sample.direction);
    const vfloat zero = 0.0f, own = light_count * sample.density;
    const vmask is_weighed = (sample.density > zero) & (scatter_count > zero) &
                             (own < vfloat(std::numeric_limits<float>::infinity()));
    const vfloat weight = select(is_weighed, own / (own + scatter_count * f.density), vfloat(1.0f));
    const VecLanes light = times(f.light, sample.radiance) * weight;
    return {sample.direction, sample.distance, select(is_black(sample.radiance), all_channels(zero), light), sample.density};
}

// Returns the directions to which visible normals reflect the eye.
VecLanes SurfaceLanes::reflected_at(const FrameLanes& axes, vfloat alpha, const DiscPoints& at) const noexcept
{
    const VecLanes to_eye = to_eye_.lanes();
    VecLanes eye = axes.to_local(to_eye);
    eye.z = max(vfloat(1e-4f), eye.z);
    const VecLanes h = axes.to_world(visible_normals(normalized(eye), alpha, at.x, at.y));
    return normalized(h * (2 * dot(to_eye, h)) - to_eye);
}

// Returns directions that follow the light of several bounces, for some of the surfaces. So few are drawn at once that they
// are made one by one.
VecLanes SurfaceLanes::multiple_at(const FrameLanes& axes, vmask of, vfloat u, vfloat v,
                                   const VecLanes& otherwise) const noexcept
{
    LaneFloats us, vs;
    us = u, vs = v;
    LaneVectors local;
    for (int lane = 0; lane < kLanes; ++lane)
        local.set(lane,
                  (bits(of) >> lane & 1) != 0 ? multiple_direction({us.of[lane], vs.of[lane]}, row_.at(lane)) : Vec3f(0));
    return select(of, axes.to_world(local.lanes()), otherwise);
}

SurfaceLanes::Samples SurfaceLanes::sample_scatter(vfloat choice, vfloat u, vfloat v) const noexcept
{
    const vfloat zero = 0.0f;
    const vmask is_diffuse = choice < share_diffuse_;
    const vfloat above_diffuse = choice - share_diffuse_;
    const vmask is_multiple = andnot(above_diffuse < share_multiple_, is_diffuse), is_base = is_diffuse | is_multiple;
    const vmask is_layer = andnot(above_diffuse - share_multiple_ < share_layer_, is_base);
    const vmask is_coat = andnot(share_coat_ > zero, is_base | is_layer);
    const FrameLanes axes(normal_.lanes());
    const DiscPoints d(u, v);
    VecLanes direction = axes.to_world({d.x, d.y, sqrt(max(1 - d.x * d.x - d.y * d.y, zero))});
    if (any(is_multiple)) direction = multiple_at(axes, is_multiple, u, v, direction);
    if (any(is_layer)) direction = select(is_layer, reflected_at(axes, alpha_.lanes(), d), direction);
    if (any(is_coat))
        direction = select(is_coat, reflected_at(FrameLanes(coat_normal_.lanes()), coat_alpha_.lanes(), d), direction);
    direction = select(is_base | is_layer | is_coat, direction, all_channels(zero));
    const Scattering f = scatter_with_density(direction);
    const vfloat density = select(is_black(direction), zero, f.density);
    const vmask is_drawn = (density > zero) & (density < vfloat(std::numeric_limits<float>::infinity()));
    Samples out;
    out.directions.set(direction, density);
    const VecLanes weight = select(is_drawn, divided(f.light, density), all_channels(zero));
    out.weights.set(weight, zero);
    out.not_black = bits((weight.x > zero) | (weight.y > zero) | (weight.z > zero));
    out.of_layer = bits(is_layer);
    out.of_coat = bits(is_coat);
    return out;
}

ScatterSample SurfaceLanes::Samples::at(int lane, const Surface& surface) const noexcept
{
    ScatterSample s{directions.vector(lane), weights.vector(lane), directions.number(lane)};
    if ((of_layer >> lane & 1) != 0) {
        s.lobe = Lobe::Layer;
        s.alpha = surface.alpha;
    } else if ((of_coat >> lane & 1) != 0) {
        s.lobe = Lobe::Coat;
        s.alpha = surface.coat_alpha;
    }
    return s;
}

}  // namespace occam::shade
