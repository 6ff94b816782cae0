// The layer over the base of a surface: how much light it reflects, scatters several times and lets through.
//
// F is float for one direction, or vfloat for as many as there are lanes, with the same bits.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/maths.h"
#include "shade/albedo_table.h"
#include "shade/fresnel.h"
#include "shade/lane_vectors.h"
#include "shade/microfacet.h"

namespace occam::shade {

/// Describes the layer over the base: a lobe for its multiple scattering, and the share of light that it transmits to the
/// base and back.
template <class F>
struct LayerOf {
    F mean;              ///< mean albedo, over all directions, of a layer that reflects all light
    Triple<F> multiple;  ///< the factor of light that bounces several times between the layer's microfacets
    F f0, f90;           ///< reflectance of the dielectric over the base
    F base_multiple, base_mean;
};

/// Returns the factor of light that bounces several times between microfacets, where 1 is what single scattering lost
/// (Kulla and Conty 2017; the sum of the series F^2 E (1 + F (1 - E) + ...)), of one channel.
template <class F>
F multiple_share(F f0, F f90, F mean_albedo) noexcept
{
    const F f = f0 + (f90 - f0) / 21.0f;  // the cosine-weighted mean of Schlick's curve
    return f * f * mean_albedo / (1.0f - f * (1 - mean_albedo));
}

/// Says of what a layer is mixed: a share of it has one reflectance, and another share that of a metal. Light stays within a
/// share until it has left the layer, so that each loses what a layer of its kind alone would lose.
template <class F>
struct LayerMixOf {
    Triple<F> f0;  ///< reflectance of the first share, which is the dielectric, or all that there is
    F f90, share;
    Triple<F> metal_f0;
    F metal_share;
};

/// Sets what follows from the reflectances.
/// all   mean of the albedo over all directions
template <class F>
void complete(LayerOf<F>& of, const LayerMixOf<F>& mix, LayerAlbedoOf<F> all) noexcept
{
    of.mean = all.sum();
    const auto multiple = [&](F f0, F metal_f0) {
        return mix.share * multiple_share(f0, mix.f90, of.mean) +
               mix.metal_share * multiple_share(metal_f0, F(1.0f), of.mean);
    };
    of.multiple = {multiple(mix.f0.x, mix.metal_f0.x), multiple(mix.f0.y, mix.metal_f0.y),
                   multiple(mix.f0.z, mix.metal_f0.z)};
    of.base_multiple = multiple_share(of.f0, of.f90, of.mean);
    of.base_mean = of.f0 * all.f0 + of.f90 * all.f90 + of.base_multiple * (1 - of.mean);
}

/// Returns the share of a direction's light that gets below the dielectric.
template <class F>
F through(const LayerOf<F>& of, LayerAlbedoOf<F> e) noexcept
{
    return max(1.0f - (of.f0 * e.f0 + of.f90 * e.f90 + of.base_multiple * (1 - e.sum())), F(0.0f));
}

/// Returns the factor of the base: reciprocal, and exact for a white base (Kelemen and Szirmay-Kalos 2001, sec. 3).
template <class F>
F into_base(const LayerOf<F>& of, LayerAlbedoOf<F> eye, LayerAlbedoOf<F> light) noexcept
{
    return select(of.base_mean < 1, through(of, eye) * through(of, light) / (1 - of.base_mean), F(0.0f));
}

/// Returns the lobe of light that bounces several times.
template <class F>
Triple<F> multiple_lobe(const LayerOf<F>& of, LayerAlbedoOf<F> eye, LayerAlbedoOf<F> light) noexcept
{
    const F lost = (1 - eye.sum()) * (1 - light.sum()) / ((1 - of.mean) * kPi);
    return of.multiple * select(of.mean < 1, max(lost, F(0.0f)), F(0.0f));
}

/// Returns the density of directions that are drawn in the shape of that lobe, per solid angle.
/// light    the albedo of the direction
/// cosine   of the direction
/// lost     of the table of albedos
template <class F>
F multiple_density(LayerAlbedoOf<F> light, F cosine, F lost) noexcept
{
    return max(1 - light.sum(), F(0.0f)) * max(cosine, F(0.0f)) / (kPi * lost);
}

/// Returns a direction about +z of that density.
inline Vec3f multiple_direction(Vec2f square, AlbedoTable::Row row) noexcept
{
    const float z = AlbedoTable::instance().draw_lost(square.x, row), radius = std::sqrt(std::max(0.0f, 1 - z * z));
    const float angle = 2 * kPi * square.y;
    return {radius * maths::cos(angle), radius * maths::sin(angle), z};
}

/// Returns the reflectance of the layer under Schlick's curve, whose weight is g.
template <class F>
Triple<F> reflectance(const Triple<F>& f0, F f90, F g) noexcept
{
    return f0 * (1 - g) + all_channels(f90 * g);
}

/// The lobe of a layer is faded at directions so much lower than those at which the base is.
inline constexpr float kSteepLobe = 0.4f;

/// Returns 1 from side = along on, and what falls smoothly to 0 at side = 0 (Chiang et al. 2019, eq. 1 to 3).
template <class F>
F faded(F side, F along) noexcept
{
    const F ratio = side / along;
    return select(side >= along, F(1.0f), select(side > 0, ratio * (1 + ratio * (1 - ratio)), F(0.0f)));
}

}  // namespace occam::shade
