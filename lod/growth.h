// What becomes of a cage that grows by a large factor while the shutter is open.
//
// Rates are those of the largest key. Where a cage is much smaller than there, all of its micropolygons lie in one place,
// and a ray of that moment meets them all; so a cage that grows that much has no fine edges. The boxes of a moving surface
// are padded for the rounding where it is largest, so at some size they are nearly all padding, and a ray would meet all of
// them; so a cage is left out while it is that small.
//
// Threads  any.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

namespace occam::lod {

/// A cage that grows by more than this factor has no edges below a 128th of its largest radius.
inline constexpr double kMostGrowth = 4096;
/// A cage is left out of the segments of the shutter in which its radius stays below this share of its largest one. With the
/// padding of boxes, 4 ulps, a ray meets about a sixteenth of the surface there.
inline constexpr double kLeastShown = 0x1p-17;

/// radii   of a cage at each of its own keys
inline bool grows_much(std::span<const double> radii) noexcept
{
    const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
    return *most > kMostGrowth * *least;
}

/// Returns a bit for each segment of the shutter in which a cage is smaller than kLeastShown at both ends.
/// step   how many segments of the shutter each of the cage's own has
inline std::uint32_t segments_of_tiny(std::span<const double> radii, int step) noexcept
{
    const double least = kLeastShown * *std::max_element(radii.begin(), radii.end());
    std::uint32_t tiny = 0;
    for (std::size_t k = 0; k + 1 < radii.size(); ++k)
        if (std::max(radii[k], radii[k + 1]) < least)
            for (int i = 0; i < step; ++i) tiny |= 1u << (static_cast<int>(k) * step + i);
    return tiny;
}

}  // namespace occam::lod
