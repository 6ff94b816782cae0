// How wide the beams of secondary rays are: path differentials, as one width across a beam that grows along it.
//
// A beam has a width w at a hit (full, world length) and a spread b = dw/dt. From these each kind of secondary ray gets its
// footprint A + B t with A = w: it starts as wide as its parent arrived. Of the two curvatures of a wave front, the one
// across the plane of incidence is followed (it is the smaller where a surface bulges), so that the footprint is the smaller
// axis of the true one. A beam that converges after a mirror or a lens is held at its width: it is then too fine beyond
// twice the focal length, which costs time and shows nothing. Igehy 1999 (mirrors, refraction); Suykens and Willems 2001
// (what is sampled: the width of one sample's share of the domain).
//
// `samples` is how many rays of one pixel share the domain in all: each speaks for one such part of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "lod/footprint.h"

namespace occam::shade {

/// A beam where it meets a surface.
struct Beam {
    float width = 0;   ///< across the beam, world length
    float spread = 0;  ///< growth of the width per world length
};

/// curvature   mean, positive where the surface bulges towards the beam, 1 / world length
/// cosine      of beam and normal
lod::Footprint mirrored_beam(Beam beam, float curvature, float cosine) noexcept;

/// eta          refractive index behind the surface over that in front
/// cosine_out   of the bent beam and the normal, both above 0
lod::Footprint bent_beam(Beam beam, float curvature, float cosine, float cosine_out, float eta) noexcept;

/// `smooth` is what a mirror or lens would make of the beam; a direction drawn with `density` per solid angle stands
/// for 1 / (density * samples) of it. The two widths are independent: their squares add.
lod::Footprint scattered_beam(lod::Footprint smooth, float density, int samples) noexcept;

/// The same, growing no faster than levels of detail can follow. A steeper beam would be wider at its hit than the levels
/// that were seen there, and a ray that goes on from the hit with that width would meet a coarser surface, and be on the
/// wrong side of it. shading_rate   wanted edge over the beam's width
lod::Footprint followable(lod::Footprint beam, float shading_rate, const lod::LevelSettings& levels = {}) noexcept;

/// Towards a light that is `distance` away and drawn with `density` per solid angle: from the beam's width at the point to
/// that of the light's share. No narrower than an eighth of the start: a light without extent is met by beams of
/// no width, whose levels have no end. At infinity (parallel light) the share is an angle, added to the width.
/// density      0: the light has no extent
lod::Footprint light_beam(float width, float distance, float density, int samples) noexcept;

/// Camera rays through a lens: of the pixel's own growth and of the part of the lens's diameter that one sample
/// stands for. The disc of confusion shrinks up to the focus and grows behind it: two footprints that meet there.
struct LensBeams {
    lod::Footprint near_side, far_side;
};
/// focus       distance along the ray; pixel: the beam of a pinhole, or of parallel rays
LensBeams lens_beams(lod::Footprint pixel, float diameter, float focus, int samples) noexcept;

/// The side of a square of a hemisphere's solid angle, 2 pi.
inline constexpr float kWidestSpread = 2.5066283f;

/// Side of the square of one sample's solid angle.
inline float share_width(float density, int samples) noexcept
{
    const float shares = density * static_cast<float>(samples);
    return shares > 0 ? std::min(1 / std::sqrt(shares), kWidestSpread) : kWidestSpread;
}

inline lod::Footprint from_width(float width, float spread) noexcept
{
    // A facet's edge may have any curvature; a beam is never wider than a hemisphere.
    return {width, std::isfinite(spread) ? std::clamp(spread, 0.0f, kWidestSpread) : 0.0f};
}

inline lod::Footprint light_beam(float width, float distance, float density, int samples) noexcept
{
    constexpr float kNarrowestAtLight = 1.0f / 8;
    const float angle = density > 0 ? share_width(density, samples) : 0;
    if (!(distance < std::numeric_limits<float>::infinity())) return from_width(width, angle);
    if (!(distance > 0)) return {width, 0};
    const float at_light = std::max(angle * distance, width * kNarrowestAtLight);
    return {width, std::min((at_light - width) / distance, kWidestSpread)};
}

}  // namespace occam::shade
