#include "shade/transmission.h"

#include "shade/fresnel.h"

namespace occam::shade {
namespace {

// Describes a microfacet that sends light from a direction to the eye.
struct Facet {
    float density = 0;  ///< density of the direction per solid angle, if all visible microfacets acted like this one
    float v_h = 0;      ///< cosine between the eye and the microfacet normal
};

// Returns the microfacet that refracts (Walter et al. 2007, eq. 16 and 17), with indices in units of the eye's side.
Facet refracting_facet(const Surface& s, Vec3f to_light) noexcept
{
    Vec3f h = s.to_eye + to_light * s.eta;
    const float length = glm::length(h);
    h = length > 0 ? h / length : s.normal;
    if (glm::dot(h, s.normal) < 0) h = -h;
    const Vec3f across = glm::cross(s.normal, h);
    const float v_h = glm::dot(s.to_eye, h), l_h = glm::dot(to_light, h);
    if (!(v_h > 0 && l_h < 0)) return {};
    const float sum = v_h + s.eta * l_h, jacobian = s.eta * s.eta * -l_h / std::max(sum * sum, 1e-20f);
    const float visible = visible_density_over_cosine(eye_cosine(s.normal, s.to_eye), glm::dot(s.normal, h),
                                                      glm::dot(across, across), s.alpha);
    return {visible * v_h * jacobian, v_h};
}

Facet reflecting_facet(const Surface& s, Vec3f to_light) noexcept
{
    Vec3f h = s.to_eye + to_light;
    const float length = glm::length(h);
    h = length > 0 ? h / length : s.normal;
    const Vec3f across = glm::cross(s.normal, h);
    const float v_h = glm::dot(s.to_eye, h);
    if (!(v_h > 0)) return {};
    return {visible_density_over_cosine(eye_cosine(s.normal, s.to_eye), glm::dot(s.normal, h), glm::dot(across, across),
                                        s.alpha) /
                4,
            v_h};
}

// Calls use(density, chance to reflect, Fresnel reflectance, whether it reflects) for the microfacets that send light
// from the direction to the eye: one directly, and one by way of the direction's mirror image at the facet.
template <class Use>
void for_facets(const Surface& s, Vec3f to_light, Use&& use) noexcept
{
    const bool reflects = glm::dot(s.normal_geometric, to_light) > 0;
    for (const Vec3f direction : {to_light, turned(to_light, s.normal_geometric)}) {
        const Facet facet = reflects ? reflecting_facet(s, direction) : refracting_facet(s, direction);
        if (!(facet.density > 0)) continue;
        use(facet.density, mirror_chance(s, facet.v_h), fresnel_dielectric(std::min(facet.v_h, 1.0f), s.eta), reflects);
    }
}

Vec3f refracted(const Surface& s, Vec3f h) noexcept
{
    const float cosine = glm::dot(s.to_eye, h);
    const float sin2_behind = (1 - cosine * cosine) / (s.eta * s.eta);
    if (!(cosine > 0) || sin2_behind >= 1) return Vec3f(0);
    return glm::normalize(h * (cosine / s.eta - std::sqrt(1 - sin2_behind)) - s.to_eye / s.eta);
}

}  // namespace

Vec3f through_pane(const Surface& s, Vec3f h) noexcept
{
    return behind_facet(s, glm::normalize(turned(h * (2 * glm::dot(s.to_eye, h)) - s.to_eye, s.normal)));
}

Vec3f pane_transmission(const Surface& s, Vec3f to_light) noexcept
{
    const float n_l = -glm::dot(s.normal, to_light);
    if (!(n_l > 0)) return Vec3f(0);
    const Vec3f h = glm::normalize(s.to_eye + turned(to_light, s.normal));
    const Vec3f across = glm::cross(s.normal, h);
    const float n_v = eye_cosine(s.normal, s.to_eye), n_h = glm::dot(s.normal, h);
    if (!(n_h > 0)) return Vec3f(0);  // no such direction is drawn: pane_density() is 0
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

Vec3f through_body(const Surface& s, Vec3f h, float choice) noexcept
{
    const bool reflects = choice < mirror_chance(s, glm::dot(s.to_eye, h));
    const Vec3f d = reflects ? glm::normalize(h * (2 * glm::dot(s.to_eye, h)) - s.to_eye) : refracted(s, h);
    return (glm::dot(s.normal_geometric, d) > 0) == reflects ? d : turned(d, s.normal_geometric);
}

Vec3f body_scattering(const Surface& s, Vec3f to_light) noexcept
{
    Vec3f f(0);
    for_facets(s, to_light, [&](float density, float, float fresnel, bool reflects) {
        f += reflects ? Vec3f(fresnel * density) : s.transmission * ((1 - fresnel) * density);
    });
    return f;
}

float body_density(const Surface& s, Vec3f to_light) noexcept
{
    float sum = 0;
    for_facets(s, to_light, [&](float density, float mirror, float, bool reflects) {
        sum += (reflects ? mirror : 1 - mirror) * density;
    });
    return sum;
}

}  // namespace occam::shade
