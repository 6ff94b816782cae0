// The widths of the beams of secondary rays: path differentials, kept as one width across a beam that grows along it.
//
// A beam has a width w at a hit (its full width, a frame length) and a spread b = dw/dt. From these each kind of
// secondary ray gets its footprint A + B t with A = w: it starts as wide as its parent arrived. Of the two curvatures of
// a wave front, the one across the plane of incidence is followed (it is the smaller one where a surface bulges), so that
// the footprint is the smaller axis of the true one. A beam that converges after a mirror or a lens keeps its width. It
// is then too fine beyond twice the focal length, which costs time but is not visible. The sources are Igehy 1999
// (reflection and refraction) and Suykens and Willems 2001 (sampled directions: the width of one sample's share of the
// domain).
//
// `samples` is the number of rays of one pixel that share the domain in all, so each of them covers one such part of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/simd.h"
#include "lod/footprint.h"

namespace occam::shade {

/// Describes a beam where it hits a surface.
struct Beam {
    float width = 0;   ///< across the beam, in frame lengths
    float spread = 0;  ///< growth of the width per length along it
};

/// Returns the footprint of the reflected beam.
/// curvature   mean curvature, positive where the surface bulges towards the beam, in 1 / frame length
/// cosine      between the beam and the normal
lod::Footprint mirrored_beam(Beam beam, float curvature, float cosine) noexcept;

/// Returns the footprint of the refracted beam.
/// eta          refractive index behind the surface over that in front
/// cosine_out   between the refracted beam and the normal; both cosines are above 0
lod::Footprint refracted_footprint(Beam beam, float curvature, float cosine, float cosine_out, float eta) noexcept;

/// Returns the footprint of a sampled direction. `smooth` is what a smooth mirror or lens would make of the beam. A
/// direction drawn with `density` per solid angle covers a solid angle of 1 / (density * samples). The two widths are
/// independent, so their squares are added.
lod::Footprint scattered_beam(lod::Footprint smooth, float density, int samples) noexcept;

/// Returns the same beam, growing no faster than levels of detail can follow. A steeper beam would be wider at its hit
/// than the levels that were seen there. A ray that goes on from the hit with that width would see a coarser surface, and
/// could be on the wrong side of it.
/// shading_rate   target edge length over the width of the beam
lod::Footprint followable(lod::Footprint beam, float shading_rate) noexcept;

/// Returns the spread of the footprint towards a light that is `distance` away and drawn with `density` per solid angle. The
/// footprint goes from `width`, that of the beam at the point, to that of the sample's share of the light, and is no
/// narrower than an eighth of the width at the start, since a beam without width at its end would ask for infinitely fine
/// levels. At infinity (parallel light) the share is an angle, which is added to the width. F is float, or vfloat for
/// several lights.
///
/// density   0: the light has no extent
template <class F>
F light_spread(F width, F distance, F density, F samples) noexcept;

/// Holds the footprints of a camera ray through a lens. They are made of the growth of the pixel itself and of the part
/// of the lens's diameter that one sample covers. The circle of confusion shrinks up to the focus and grows behind it, so
/// there are two footprints that join there.
struct LensBeams {
    lod::Footprint near_side, far_side;
};
/// Returns the width of one sample's part of a lens.
inline float lens_share(float diameter, int samples) noexcept { return diameter / std::sqrt(static_cast<float>(samples)); }
/// Returns the footprints of a ray through a lens.
/// focus       distance along the ray
/// pixel       the beam of a pinhole camera, or of parallel rays
LensBeams lens_beams(lod::Footprint pixel, float diameter, float focus, int samples) noexcept;

/// The side of a square with the solid angle of a hemisphere, 2 pi.
inline constexpr float kWidestSpread = 2.5066283f;

/// Returns the side of a square with the solid angle of one sample. F is float or vfloat.
template <class F>
F share_width(F density, F samples) noexcept
{
    const F shares = density * samples, widest = kWidestSpread;
    return select(shares > 0, min(widest, 1 / sqrt(shares)), widest);
}

inline lod::Footprint from_width(float width, float spread) noexcept
{
    // The edge of a facet may have any curvature, but a beam is never wider than a hemisphere.
    return {width, std::isfinite(spread) ? std::clamp(spread, 0.0f, kWidestSpread) : 0.0f};
}

template <class F>
F light_spread(F width, F distance, F density, F samples) noexcept
{
    constexpr float kNarrowestAtLight = 1.0f / 8;
    const F zero = 0.0f, angle = select(density > 0, share_width(density, samples), zero);
    const F at_light = max(width * kNarrowestAtLight, angle * distance);
    const F to_light = select(distance > 0, min(F(kWidestSpread), (at_light - width) / distance), zero);
    return select(distance < std::numeric_limits<float>::infinity(), to_light, angle);
}

}  // namespace occam::shade
