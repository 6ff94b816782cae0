// Fresnel reflectance of smooth boundaries.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/simd.h"
#include "shade/albedo_table.h"

namespace occam::shade {

/// Returns (1 - cosine)^5: the weight w of f90 in f0 (1 - w) + f90 w (Schlick 1994). F is float or vfloat.
template <class F>
F schlick(F cosine) noexcept
{
    const F x = clamp(F(1.0f - cosine), F(0.0f), F(1.0f));
    const F x2 = x * x;
    return x2 * x2 * x;
}

/// Returns the unpolarised reflectance of a dielectric (Fresnel's equations). `cosine` is in [0, 1] on the incident side,
/// and `eta` is the index behind over the index in front. The result is 1 where light is totally reflected.
inline float fresnel_dielectric(float cosine, float eta) noexcept
{
    const float sin2_behind = (1 - cosine * cosine) / (eta * eta);
    if (sin2_behind >= 1) return 1;
    const float behind = std::sqrt(1 - sin2_behind);
    const float parallel = (eta * cosine - behind) / (eta * cosine + behind);
    const float across = (cosine - eta * behind) / (cosine + eta * behind);
    return 0.5f * (parallel * parallel + across * across);
}

/// The reflectance of a coat at normal incidence (KHR_materials_clearcoat: an index of 1.5).
inline constexpr float kCoatF0 = 0.04f;

/// Returns the share of light from one direction that a coat reflects in all.
inline float coat_albedo(float cosine, float alpha) noexcept
{
    const LayerAlbedo e = AlbedoTable::instance().at(cosine, alpha);
    return kCoatF0 * e.f0 + e.f90;
}

}  // namespace occam::shade
