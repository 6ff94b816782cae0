#include "shade/bsdf.h"

#include <algorithm>

#include "shade/frame_of.h"

namespace occam::shade {
namespace {

float luminance(Vec3f c) noexcept { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

float fifth_power(float x) noexcept
{
    const float x2 = x * x;
    return x2 * x2 * x;
}

// Schlick 1994.
float grazing(float v_dot_h) noexcept { return fifth_power(std::clamp(1 - v_dot_h, 0.0f, 1.0f)); }

// Distribution of normals, Walter et al. 2007, eq. 33, isotropic. In sin^2 = 1 - cos^2 of the half vector's cross
// product with the normal, since 1 - n_h^2 loses all digits of a narrow lobe.
float ggx(float n_h, float sin2_h, float alpha) noexcept
{
    const float d = sin2_h + n_h * n_h * alpha * alpha;
    return alpha * alpha / (kPi * d * d);
}

// Height-correlated masking and shadowing over 4 n_l n_v (Heitz 2014, eq. 99).
float visibility(float n_l, float n_v, float alpha) noexcept
{
    const float a2 = alpha * alpha;
    const float l = n_v * std::sqrt(n_l * n_l * (1 - a2) + a2);
    const float v = n_l * std::sqrt(n_v * n_v * (1 - a2) + a2);
    return 0.5f / std::max(l + v, 1e-12f);
}

// A shading normal may lean away from the eye; the cosine is then held just above zero.
constexpr float kMinCosine = 1e-4f;

struct Angles {
    float n_l, n_v, n_h, v_h, sin2_h;

    Angles(const Surface& s, Vec3f to_light) noexcept
    {
        const Vec3f half = s.to_eye + to_light;
        const float length = glm::length(half);
        const Vec3f h = length > 0 ? half / length : s.normal;
        const Vec3f across = glm::cross(s.normal, h);
        n_l = glm::dot(s.normal, to_light);
        n_v = std::max(glm::dot(s.normal, s.to_eye), kMinCosine);
        n_h = glm::dot(s.normal, h);
        v_h = glm::dot(s.to_eye, h);
        sin2_h = glm::dot(across, across);
    }
};

// Share of the light that the dielectric layer lets down to the base and back up: what it reflects on the way in and on the
// way out is gone, so that a white base under a smooth layer reflects exactly 1 (Kelemen and Szirmay-Kalos 2001, sec. 3).
// A rough layer reflects little at grazing angles; there its curve ends below f90 (fitted).
// Departs from glTF's appendix B, whose 1 - F of the half vector gains up to 70 % at grazing angles. Held by
// Bsdf.AWhiteFurnaceNeverGainsLight.
float into_base(const Surface& s, const Angles& a) noexcept
{
    const float f0 = s.dielectric_f0;
    const float rise = std::max(0.0f, s.dielectric_f90 * (1 - 0.9f * s.alpha) - f0);
    const auto let_through = [&](float cosine) { return 1 - f0 - rise * grazing(cosine); };
    // Schlick's curve weighted with the cosine, over the hemisphere, is f0 + rise / 21.
    const float mean = 1 - f0 - rise / 21;
    return mean > 0 ? let_through(a.n_l) * let_through(a.n_v) / mean : 0;
}

// How often each lobe is sampled: by what it reflects at this angle.
struct LobeShares {
    float diffuse, base, coat;

    explicit LobeShares(const Surface& s) noexcept
    {
        const float n_v = std::max(glm::dot(s.normal, s.to_eye), kMinCosine);
        const float g = grazing(n_v);
        coat = s.coat * (0.04f + 0.96f * g);
        base = (1 - coat) * (luminance(s.f0) * (1 - g) + s.f90 * g);
        diffuse = (1 - coat) * luminance(s.diffuse);
        const float sum = diffuse + base + coat;
        if (!(sum > 0)) {
            *this = {};
            return;
        }
        // None is starved: a texture's dark texel must not make its highlight noisy.
        diffuse = luminance(s.diffuse) > 0 ? 0.05f + 0.9f * diffuse / sum : 0;
        base = 0.05f + 0.9f * base / sum;
        coat = s.coat > 0 ? 0.05f + 0.9f * coat / sum : 0;
        const float scale = 1 / (diffuse + base + coat);
        diffuse *= scale;
        base *= scale;
        coat *= scale;
    }

private:
    LobeShares() noexcept : diffuse(1), base(0), coat(0) {}
};

// A normal among those that the eye sees (Heitz 2018, sec. 4: the unit hemisphere, stretched by alpha).
Vec3f visible_normal(Vec3f eye, float alpha, Vec2f square) noexcept
{
    const Vec3f stretched = glm::normalize(Vec3f(alpha * eye.x, alpha * eye.y, eye.z));
    const float flat2 = stretched.x * stretched.x + stretched.y * stretched.y;
    const Vec3f t1 = flat2 > 0 ? Vec3f(-stretched.y, stretched.x, 0) / std::sqrt(flat2) : Vec3f(1, 0, 0);
    const Vec3f t2 = glm::cross(stretched, t1);
    Vec2f p = disc_point(square);
    const float s = 0.5f * (1 + stretched.z);
    p.y = (1 - s) * std::sqrt(std::max(0.0f, 1 - p.x * p.x)) + s * p.y;
    const float up = std::sqrt(std::max(0.0f, 1 - p.x * p.x - p.y * p.y));
    const Vec3f h = t1 * p.x + t2 * p.y + stretched * up;
    return glm::normalize(Vec3f(alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)));
}

// Density of the direction mirrored at visible_normal(): G1 D / (4 n_v) (Heitz 2018, eq. 17).
float visible_density(const Angles& a, float alpha) noexcept
{
    if (!(a.n_h > 0)) return 0;
    const float a2 = alpha * alpha;
    const float masking = 2 / (a.n_v + std::sqrt(a2 + (1 - a2) * a.n_v * a.n_v));  // G1 / n_v
    return masking * ggx(a.n_h, a.sin2_h, alpha) / 4;
}

}  // namespace

Vec3f reflect(const Surface& s, Vec3f to_light) noexcept
{
    const Angles a(s, to_light);
    if (!(a.n_l > 0) || !(glm::dot(s.normal_geometric, to_light) > 0)) return Vec3f(0);

    const float g = grazing(a.v_h);
    const Vec3f fresnel = s.f0 * (1 - g) + Vec3f(s.f90) * g;
    Vec3f f =
        s.diffuse * (into_base(s, a) / kPi) + fresnel * (ggx(a.n_h, a.sin2_h, s.alpha) * visibility(a.n_l, a.n_v, s.alpha));
    if (s.coat > 0) {
        const float coat = s.coat * (0.04f + 0.96f * g);  // KHR_materials_clearcoat: a dielectric of ior 1.5
        f = f * (1 - coat) + Vec3f(coat * ggx(a.n_h, a.sin2_h, s.coat_alpha) * visibility(a.n_l, a.n_v, s.coat_alpha));
    }
    return f * a.n_l;
}

Vec3f sample_direction(const Surface& s, float lobe, Vec2f square) noexcept
{
    const LobeShares share(s);
    const Axes axes(s.normal);
    if (lobe < share.diffuse) return axes.to_world(cosine_direction(square));
    const float alpha = lobe < share.diffuse + share.base ? s.alpha : s.coat_alpha;
    Vec3f eye = axes.to_local(s.to_eye);
    eye.z = std::max(eye.z, kMinCosine);
    const Vec3f h = axes.to_world(visible_normal(glm::normalize(eye), std::max(alpha, kMinAlpha), square));
    return glm::normalize(h * (2 * glm::dot(s.to_eye, h)) - s.to_eye);
}

float direction_density(const Surface& s, Vec3f to_light) noexcept
{
    const Angles a(s, to_light);
    const LobeShares share(s);
    float density = share.diffuse * std::max(a.n_l, 0.0f) / kPi + share.base * visible_density(a, s.alpha);
    if (s.coat > 0) density += share.coat * visible_density(a, s.coat_alpha);
    return density;
}

}  // namespace occam::shade
