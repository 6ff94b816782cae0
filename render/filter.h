// Reconstruction filters by importance sampling: the position of a sample follows the filter, and its weight is the sign
// of the filter.
//
// Every sample then belongs to one pixel alone (Ernst et al. 2006), so that no sum crosses a border of tiles. Filters are
// separable. Box and tent are sampled exactly. The others are sampled from a table of their absolute value; its steps
// need no correction of the weights, because the tabulated filter is the one in use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/vec.h"

namespace occam::render {

enum class FilterKind : std::uint8_t { Box, Tent, Gaussian, BlackmanHarris, Mitchell };
struct FilterRow {
    FilterKind kind;
    std::string_view name;
    float radius;  ///< half the usual width, in pixels
};
/// The rows stand in the order of the kinds.
inline constexpr FilterRow kFilters[] = {
    {FilterKind::Box, "box", 0.5f},           {FilterKind::Tent, "tent", 1},
    {FilterKind::Gaussian, "gaussian", 1.5f}, {FilterKind::BlackmanHarris, "blackman-harris", 1.65f},
    {FilterKind::Mitchell, "mitchell", 2},
};
constexpr const FilterRow& row_of(FilterKind kind) noexcept { return kFilters[static_cast<std::size_t>(kind)]; }

class PixelFilter {
public:
    /// radius   half the width in pixels; 0: the usual one
    explicit PixelFilter(FilterKind kind, float radius = 0);

    struct Place {
        Vec2f offset;  ///< offset from the middle of the pixel, in pixels
        float weight;  ///< 1 or -1
    };
    /// Returns the place of a sample; `square` is uniform in [0, 1).
    Place place(Vec2f square) const noexcept;

    /// Returns the filter along one axis, not normalised; x is in pixels from the middle of the filter.
    float value(float x) const noexcept;
    float radius() const noexcept { return radius_; }

private:
    static constexpr int kSteps = 256;

    /// Returns a place on one axis, in half widths.
    float place_on_axis(float u) const noexcept;

    FilterKind kind_;
    float radius_;
    std::array<float, kSteps + 1> sums_{};  ///< running sums of the absolute value, from 0 to 1
};

}  // namespace occam::render
