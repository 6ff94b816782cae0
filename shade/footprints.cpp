#include "shade/footprints.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam::shade {
namespace {

// The side of a square of a hemisphere's solid angle, 2 pi.
constexpr float kWidestSpread = 2.5066283f;
constexpr float kNarrowestAtLight = 1.0f / 8;

// Side of the square of one sample's solid angle.
float share_width(float density, int samples) noexcept
{
    const float shares = density * static_cast<float>(samples);
    return shares > 0 ? std::min(1 / std::sqrt(shares), kWidestSpread) : kWidestSpread;
}

lod::Footprint from_width(float width, float spread) noexcept
{
    // A facet's edge may have any curvature; a beam is never wider than a hemisphere.
    return {width, std::isfinite(spread) ? std::clamp(spread, 0.0f, kWidestSpread) : 0.0f};
}

}  // namespace

// Coddington's equation for a mirror, across the plane of incidence: 1/s' = 1/s + 2 k cos, and w'/w = 1/s.
lod::Footprint mirrored_beam(Beam beam, float curvature, float cosine) noexcept
{
    return from_width(beam.width, beam.spread + 2 * curvature * cosine * beam.width);
}

// The same for refraction: eta / s' = 1 / s + k (cos - eta cos').
lod::Footprint bent_beam(Beam beam, float curvature, float cosine, float cosine_out, float eta) noexcept
{
    return from_width(beam.width, (beam.spread + curvature * beam.width * (cosine - eta * cosine_out)) / eta);
}

lod::Footprint scattered_beam(lod::Footprint smooth, float density, int samples) noexcept
{
    const float share = share_width(density, samples);
    return from_width(smooth.a, std::sqrt(smooth.b * smooth.b + share * share));
}

// A segment between two transitions is two margins long, each of 2 d and an overlap (lod/ray_levels.h), and in it the wanted edge
// grows by d.
lod::Footprint followable(lod::Footprint beam, float shading_rate, const lod::LevelSettings& levels) noexcept
{
    const float wanted = shading_rate * lod::LevelSettings::kLongestEdge;
    return {beam.a, std::min(beam.b, 1 / ((4 + 2 * levels.overlap_edges) * wanted))};
}

lod::Footprint light_beam(float width, float distance, float density, int samples) noexcept
{
    const float angle = density > 0 ? share_width(density, samples) : 0;
    if (!(distance < std::numeric_limits<float>::infinity())) return from_width(width, angle);
    if (!(distance > 0)) return {width, 0};
    const float at_light = std::max(angle * distance, width * kNarrowestAtLight);
    return {width, std::min((at_light - width) / distance, kWidestSpread)};
}

LensBeams lens_beams(lod::Footprint pixel, float diameter, float focus, int samples) noexcept
{
    const float share = diameter / std::sqrt(static_cast<float>(samples));
    const float slope = share / focus;
    return {{pixel.a + share, pixel.b - slope}, {pixel.a - share, pixel.b + slope}};
}

}  // namespace occam::shade
