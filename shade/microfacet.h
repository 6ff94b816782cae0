// The GGX distribution of microfacet normals: density, masking and visible normals.
//
// Cosines are those of unit vectors against the macroscopic normal. `sin2_h` is the squared length of the cross product
// of normal and microfacet normal, since 1 - cos^2 would lose all digits of a narrow lobe. The first functions are
// isotropic. F is float for one direction or vfloat for several, with the same bits. The sources are Walter et al. 2007
// (distribution), Heitz 2014 (masking) and Heitz 2018 (visible normals).
#pragma once

#include <algorithm>
#include <cmath>

#include "base/simd.h"
#include "shade/frame_of.h"

namespace occam::shade {

/// The narrowest GGX width. A mirror is sampled as a lobe of this width, so that no density is infinite. The lobe of
/// reflected directions is twice as wide, 6e-4 radians, which is less than a pixel of a frame that is 1600 pixels wide, with
/// a field of view of 60 degrees.
inline constexpr float kMinAlpha = 3e-4f;

/// Returns the density of normals per solid angle (Walter et al. 2007, eq. 33).
template <class F>
F ggx_density(F n_h, F sin2_h, F alpha) noexcept
{
    const F d = sin2_h + n_h * n_h * alpha * alpha;
    return alpha * alpha / (kPi * d * d);
}

/// Returns the root by which ggx_visibility() depends on one of its cosines.
template <class F>
F ggx_root(F cosine, F alpha) noexcept
{
    const F a2 = alpha * alpha;
    return sqrt(cosine * cosine * (1 - a2) + a2);
}

/// Returns the height-correlated masking and shadowing over 4 n_l n_v (Heitz 2014, eq. 99); both cosines are above zero.
/// root_v   ggx_root() of n_v
template <class F>
F ggx_visibility(F n_l, F n_v, F root_v, F alpha) noexcept
{
    return 0.5f / max(F(1e-12f), n_v * ggx_root(n_l, alpha) + n_l * root_v);
}
inline float ggx_visibility(float n_l, float n_v, float alpha) noexcept
{
    return ggx_visibility(n_l, n_v, ggx_root(n_v, alpha), alpha);
}

/// Returns the masking of one direction over its cosine: G1(v) / n_v (Heitz 2014, eq. 43 and 72).
template <class F>
F ggx_masking_over_cosine(F n_v, F alpha) noexcept
{
    const F a2 = alpha * alpha;
    return 2 / (n_v + sqrt(a2 + (1 - a2) * n_v * n_v));
}

/// Returns the visible normal, in axes whose z is the macroscopic normal, that belongs to a point of the unit disc (Heitz
/// 2018, sec. 4). The eye is a unit direction in the same axes.
inline Vec3f visible_normal_of(Vec3f eye, float alpha, Vec2f p) noexcept
{
    const Vec3f stretched = glm::normalize(Vec3f(alpha * eye.x, alpha * eye.y, eye.z));
    const float flat2 = stretched.x * stretched.x + stretched.y * stretched.y;
    const Vec3f t1 = flat2 > 0 ? Vec3f(-stretched.y, stretched.x, 0) / std::sqrt(flat2) : Vec3f(1, 0, 0);
    const Vec3f t2 = glm::cross(stretched, t1);
    const float s = 0.5f * (1 + stretched.z);
    p.y = (1 - s) * std::sqrt(std::max(0.0f, 1 - p.x * p.x)) + s * p.y;
    const float up = std::sqrt(std::max(0.0f, 1 - p.x * p.x - p.y * p.y));
    const Vec3f h = t1 * p.x + t2 * p.y + stretched * up;
    return glm::normalize(Vec3f(alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)));
}
inline Vec3f visible_normal(Vec3f eye, float alpha, Vec2f square) noexcept
{
    return visible_normal_of(eye, alpha, disc_point(square));
}

/// Returns the density of visible_normal() divided by v_h, the cosine between eye and microfacet normal: G1 D / n_v (Heitz
/// 2018, eq. 1). The density of the reflected direction is a fourth of this value.
inline float visible_density_over_cosine(float n_v, float n_h, float sin2_h, float alpha) noexcept
{
    return n_h > 0 ? ggx_masking_over_cosine(n_v, alpha) * ggx_density(n_h, sin2_h, alpha) : 0;
}

// The following functions do the same with two widths, along x and y (Heitz 2014, eq. 85 and 86; Heitz 2018). Vectors are
// unit vectors in the axes of the lobe; their z is along the macroscopic normal and above zero.

struct Widths {
    float x, y;
    Vec3f stretched(Vec3f v) const noexcept { return {x * v.x, y * v.y, v.z}; }
};

inline float ggx_density(Vec3f h, Widths a) noexcept
{
    const float d = h.x * h.x / (a.x * a.x) + h.y * h.y / (a.y * a.y) + h.z * h.z;
    return 1 / (kPi * a.x * a.y * d * d);
}
inline float ggx_visibility(Vec3f light, Vec3f eye, Widths a) noexcept
{
    const float l = eye.z * glm::length(a.stretched(light)), v = light.z * glm::length(a.stretched(eye));
    return 0.5f / std::max(l + v, 1e-12f);
}
inline Vec3f visible_normal(Vec3f eye, Widths a, Vec2f square) noexcept
{
    const Vec3f h = visible_normal(glm::normalize(a.stretched(eye)), 1, square);
    return glm::normalize(Vec3f(a.x * h.x, a.y * h.y, std::max(1e-6f, h.z)));
}
inline float visible_density_over_cosine(Vec3f eye, Vec3f h, Widths a) noexcept
{
    return h.z > 0 ? 2 / (eye.z + glm::length(a.stretched(eye))) * ggx_density(h, a) : 0;
}

}  // namespace occam::shade
