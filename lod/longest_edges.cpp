#include "lod/longest_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lod/footprint.h"

namespace occam::lod {
namespace {

/// Returns the logarithm of twice the subdominant eigenvalue of Catmull-Clark subdivision around so many faces (Ball and
/// Storry 1988).
double growth_around(std::uint32_t faces) noexcept
{
    const double c = std::cos(2 * std::numbers::pi / double(faces));
    return std::log2((c + 5 + std::sqrt((c + 1) * (c + 9))) / 8);
}

}  // namespace

LongestEdges::LongestEdges(const Poles& poles) noexcept
{
    // A bound for the edges of random cages (tests/unit/lod_poles_test.cpp): if they have no creases, an eighth is enough.
    constexpr double kBegins = 0.25;
    std::array<double, Poles::kMostFaces.size()> growth;
    for (std::size_t c = 0; c < growth.size(); ++c) growth[c] = growth_around(Poles::kMostFaces[c]);
    for (std::size_t i = 0; i < lengths_.size(); ++i) {
        const float d = edge_length(kFinest + static_cast<int>(i));
        lengths_[i] = d;
        for (std::size_t c = 0; c < poles.longest.size(); ++c) {
            // The size of a cage may be known to a factor of two only.
            const double finer = std::min(kBegins * poles.longest[c] / double(d), 2 * kBegins * kFinestAtPoles);
            if (finer > 1) lengths_[i] = std::max(lengths_[i], d * static_cast<float>(std::pow(finer, growth[c])));
        }
    }
}

}  // namespace occam::lod
