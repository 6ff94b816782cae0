// Light that comes through a surface and is scattered by it: a rough pane, and the rough boundary of a body.
//
// The functions of panes are zero where the light is not on the far side of the shading normal. Microfacets follow GGX.
// The sources are Walter et al. 2007 (refraction) and KHR_materials_transmission (panes).
#pragma once

#include "shade/surface.h"

namespace occam::shade {

/// Returns the cosine of the eye. A shading normal may lean away from the eye; the cosine is then held just above zero.
inline float eye_cosine(Vec3f normal, Vec3f to_eye) noexcept { return std::clamp(glm::dot(normal, to_eye), 1e-4f, 1.0f); }

/// Draws a microfacet normal that is visible to the eye, in world axes.
inline Vec3f seen_normal(const ShadingFrame& axes, Vec3f to_eye, float alpha, Vec2f square) noexcept
{
    Vec3f eye = axes.to_local(to_eye);
    eye.z = std::max(eye.z, 1e-4f);
    return axes.to_world(visible_normal(glm::normalize(eye), alpha, square));
}

inline Vec3f turned(Vec3f v, Vec3f normal) noexcept { return v - normal * (2 * glm::dot(v, normal)); }

// A pane has the reflected lobe of single scattering, turned to the far side. The transmittance of several bounces is
// added by bsdf.cpp. A direction that lies behind the shading normal, but in front of the facet, is mirrored at the facet.
Vec3f pane_transmission(const Surface& surface, Vec3f to_light) noexcept;  ///< f times the cosine
float pane_density(const Surface& surface, Vec3f to_light) noexcept;
Vec3f through_pane(const Surface& surface, Vec3f microfacet) noexcept;  ///< direction of a sample
inline Vec3f behind_facet(const Surface& s, Vec3f direction) noexcept
{
    const bool is_in_front = glm::dot(s.normal, direction) < 0 && glm::dot(s.normal_geometric, direction) > 0;
    return is_in_front ? turned(direction, s.normal_geometric) : direction;
}
/// Calls use(direction) for the directions that behind_facet() takes to this one.
template <class Use>
void for_directions_of_pane(const Surface& s, Vec3f to_light, Use&& use) noexcept
{
    const bool is_behind = glm::dot(s.normal_geometric, to_light) < 0;
    if (is_behind || !(glm::dot(s.normal, to_light) < 0)) use(to_light);
    const Vec3f image = turned(to_light, s.normal_geometric);
    if (is_behind && glm::dot(s.normal, image) < 0) use(image);
}

// A body reflects or refracts at microfacets. The choice is made when the microfacet is known: beyond the angle of total
// reflection of the macroscopic normal, some microfacets still transmit light.
//
// No light is lost between microfacets: whatever a visible one reflects or refracts leaves the surface without shadowing
// by the others, and a direction that would lie on the wrong side of the facet is mirrored at it. So a body in a white
// furnace is white for any width, angle, index and shading normal, without a table. As in Turquin 2019, the masking then
// depends on the eye's side alone, and the function is not reciprocal.
float mirror_chance(const Surface& surface, float cosine_to_microfacet) noexcept;
Vec3f body_scattering(const Surface& surface, Vec3f to_light) noexcept;  ///< f times the cosine, on either side
float body_density(const Surface& surface, Vec3f to_light) noexcept;
/// Returns the direction of a sample; `choice` in [0, 1) decides between reflection and refraction.
Vec3f through_body(const Surface& surface, Vec3f microfacet, float choice) noexcept;

}  // namespace occam::shade
