#include "shade/footprints.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam::shade {

// Uses Coddington's equation for a mirror, across the plane of incidence: 1/s' = 1/s + 2 k cos, and w'/w = 1/s.
lod::Footprint mirrored_beam(Beam beam, float curvature, float cosine) noexcept
{
    return from_width(beam.width, beam.spread + 2 * curvature * cosine * beam.width);
}

// Uses the same equation for refraction: eta / s' = 1 / s + k (cos - eta cos').
lod::Footprint refracted_footprint(Beam beam, float curvature, float cosine, float cosine_out, float eta) noexcept
{
    return from_width(beam.width, (beam.spread + curvature * beam.width * (cosine - eta * cosine_out)) / eta);
}

lod::Footprint scattered_beam(lod::Footprint smooth, float density, int samples) noexcept
{
    const float share = share_width(density, static_cast<float>(samples));
    return from_width(smooth.a, std::sqrt(smooth.b * smooth.b + share * share));
}

// A segment between two transitions is two margins long, each of 2 d and an overlap (lod/ray_levels.h), and in it the
// target edge length grows by d.
lod::Footprint followable(lod::Footprint beam, float shading_rate) noexcept
{
    constexpr float kOverlapEdges = lod::LevelSettings::kOverlapEdges;
    const float target_edge = shading_rate * lod::LevelSettings::kLongestEdge;
    return {beam.a, std::min(beam.b, 1 / ((4 + 2 * kOverlapEdges) * target_edge))};
}

LensBeams lens_beams(lod::Footprint pixel, float diameter, float focus, int samples) noexcept
{
    const float share = lens_share(diameter, samples);
    const float slope = share / focus;
    return {{pixel.a + share, pixel.b - slope}, {pixel.a - share, pixel.b + slope}};
}

}  // namespace occam::shade
