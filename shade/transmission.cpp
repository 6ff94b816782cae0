#include "shade/transmission.h"

#include "shade/fresnel.h"

namespace occam::shade {
namespace {

Vec3f turned(Vec3f v, Vec3f normal) noexcept { return v - normal * (2 * glm::dot(v, normal)); }

// Cosines about the half vector of a refracted pair of directions (Walter et al. 2007, eq. 16), with indices in units of the
// eye's side.
struct Refraction {
    float n_l, n_v, n_h, sin2_h, v_h, l_h;
    bool is_valid;

    Refraction(const Surface& s, Vec3f to_light) noexcept
    {
        n_l = glm::dot(s.normal, to_light);
        n_v = eye_cosine(s.normal, s.to_eye);
        Vec3f h = s.to_eye + to_light * s.eta;
        const float length = glm::length(h);
        h = length > 0 ? h / length : s.normal;
        if (glm::dot(h, s.normal) < 0) h = -h;
        const Vec3f across = glm::cross(s.normal, h);
        n_h = glm::dot(s.normal, h);
        sin2_h = glm::dot(across, across);
        v_h = glm::dot(s.to_eye, h);
        l_h = glm::dot(to_light, h);
        is_valid = n_l < 0 && v_h > 0 && l_h < 0;
    }
    // |dh / dl| (eq. 17).
    float jacobian(float eta) const noexcept
    {
        const float sum = v_h + eta * l_h;
        return eta * eta * -l_h / std::max(sum * sum, 1e-20f);
    }
};

}  // namespace

Vec3f through_pane(const Surface& s, Vec3f h) noexcept
{
    return glm::normalize(turned(h * (2 * glm::dot(s.to_eye, h)) - s.to_eye, s.normal));
}

Vec3f pane_transmission(const Surface& s, Vec3f to_light) noexcept
{
    const float n_l = -glm::dot(s.normal, to_light);
    if (!(n_l > 0)) return Vec3f(0);
    const Vec3f h = glm::normalize(s.to_eye + turned(to_light, s.normal));
    const Vec3f across = glm::cross(s.normal, h);
    const float n_v = eye_cosine(s.normal, s.to_eye), n_h = glm::dot(s.normal, h);
    const float reflected = s.dielectric_f0 + (s.dielectric_f90 - s.dielectric_f0) * schlick(glm::dot(s.to_eye, h));
    return s.transmission *
           ((1 - reflected) * ggx_density(n_h, glm::dot(across, across), s.alpha) * ggx_visibility(n_l, n_v, s.alpha) * n_l);
}

float pane_density(const Surface& s, Vec3f to_light) noexcept
{
    const Vec3f h = glm::normalize(s.to_eye + turned(to_light, s.normal));
    const Vec3f across = glm::cross(s.normal, h);
    return visible_density_over_cosine(eye_cosine(s.normal, s.to_eye), glm::dot(s.normal, h), glm::dot(across, across),
                                       s.alpha) /
           4;
}

float mirror_chance(const Surface& s, float cosine) noexcept
{
    const float f = fresnel_dielectric(std::clamp(cosine, 0.0f, 1.0f), s.eta);
    const float through = (1 - f) * std::max({s.transmission.x, s.transmission.y, s.transmission.z});
    return f / std::max(f + through, 1e-20f);
}

Vec3f bent(const Surface& s, Vec3f h) noexcept
{
    const float cosine = glm::dot(s.to_eye, h);
    const float sin2_behind = (1 - cosine * cosine) / (s.eta * s.eta);
    if (!(cosine > 0) || sin2_behind >= 1) return Vec3f(0);
    return glm::normalize(h * (cosine / s.eta - std::sqrt(1 - sin2_behind)) - s.to_eye / s.eta);
}

Vec3f body_transmission(const Surface& s, Vec3f to_light) noexcept
{
    const Refraction r(s, to_light);
    if (!r.is_valid) return Vec3f(0);
    const float masking = ggx_masking_over_cosine(r.n_v, s.alpha) * ggx_masking_over_cosine(-r.n_l, s.alpha) * -r.n_l;
    const float through = 1 - fresnel_dielectric(std::min(r.v_h, 1.0f), s.eta);
    return s.transmission * (through * masking * ggx_density(r.n_h, r.sin2_h, s.alpha) * r.v_h * r.jacobian(s.eta));
}

float body_density(const Surface& s, Vec3f to_light) noexcept
{
    const Refraction r(s, to_light);
    if (!r.is_valid) return 0;
    return (1 - mirror_chance(s, r.v_h)) * visible_density_over_cosine(r.n_v, r.n_h, r.sin2_h, s.alpha) * r.v_h *
           r.jacobian(s.eta);
}

}  // namespace occam::shade
