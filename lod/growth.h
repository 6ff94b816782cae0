// What becomes of a cage that grows by a large factor while the shutter is open.
//
// Rates are those of the largest key. Where a cage is much smaller than there, its micropolygons are much smaller than any
// pixel, and in the end all of them lie in one place, so that a ray of that moment meets them all. The boxes of a moving
// surface are padded for the rounding where it is largest, so at some size they are nearly all padding, too. Therefore
// - segments of the shutter in which the size differs much are taken apart: the cage is posed and diced anew for each size;
// - a cage that grows much within a segment has no fine edges: there, it is small for a short time;
// - a cage is left out while it is very small.
//
// Threads  any.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace occam::lod {

/// A cage that grows by more than this factor has no edges below a 128th of its largest radius, and vertices at its keys.
inline constexpr double kMostGrowth = 4096;
/// By how many levels the finest level is coarser then; with a factor that is half as large, it is one less. The product of
/// the factor and the number of edges along a radius is 2^19 at most.
inline constexpr int kMostCoarsened = 9;
/// A cage whose sizes in two segments of the shutter differ by more than this factor is posed once for each size, in powers
/// of two.
inline constexpr double kMostAlike = 16;
/// A cage is left out of the segments of the shutter in which its radius stays below this share of its largest one. With the
/// padding of boxes, 4 ulps, a ray meets about a sixteenth of the surface there.
inline constexpr double kLeastShown = 0x1p-17;

/// radii   of a cage at each of its own keys
inline bool grows_much(std::span<const double> radii) noexcept
{
    const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
    return *most > kMostGrowth * *least;
}

/// Returns by how many levels the finest level of a cage is coarser than that of one that does not grow.
/// radii   of the cage at each of its own keys
inline int coarsened_by_growth(std::span<const double> radii) noexcept
{
    const auto [least, most] = std::minmax_element(radii.begin(), radii.end());
    int levels = kMostCoarsened;
    for (double growth = kMostGrowth; levels > 0 && *most <= 0.5 * growth * *least; growth *= 0.5) --levels;
    return levels;
}

/// Returns a bit for each segment of the shutter that is a part of a cage's own segment k.
/// step   how many segments of the shutter each of the cage's own has
inline std::uint32_t segments_within(std::size_t k, int step) noexcept
{
    const int first = static_cast<int>(k) * step;
    return (~0u >> (32 - step)) << first;
}

/// Returns a bit for each segment of the shutter in which a cage is smaller than kLeastShown at both ends.
/// radii, step   as above
inline std::uint32_t segments_of_tiny(std::span<const double> radii, int step) noexcept
{
    const double least = kLeastShown * *std::max_element(radii.begin(), radii.end());
    std::uint32_t tiny = 0;
    for (std::size_t k = 0; k + 1 < radii.size(); ++k)
        if (std::max(radii[k], radii[k + 1]) < least) tiny |= segments_within(k, step);
    return tiny;
}

/// Returns the segments of the shutter in groups of about the same size, as masks; none if all of them are about the same.
/// Segments in which the cage is smaller than kLeastShown at both ends are in no group.
/// radii, step   as above
inline std::vector<std::uint32_t> segments_by_size(std::span<const double> radii, int step)
{
    const double most = *std::max_element(radii.begin(), radii.end());
    const auto size = [&](std::size_t k) { return std::max(radii[k], radii[k + 1]); };
    double least = most;
    for (std::size_t k = 0; k + 1 < radii.size(); ++k) least = std::min(least, size(k));
    if (!(most > kMostAlike * least) || !std::isfinite(most)) return {};
    std::vector<std::uint32_t> groups;
    for (std::size_t k = 0; k + 1 < radii.size(); ++k) {
        if (size(k) < kLeastShown * most) continue;
        const auto group = static_cast<std::size_t>(std::ilogb(most / size(k)));
        if (group >= groups.size()) groups.resize(group + 1);
        groups[group] |= segments_within(k, step);
    }
    std::erase(groups, 0u);
    return groups;
}

}  // namespace occam::lod
