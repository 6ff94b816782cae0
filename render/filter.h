// Reconstruction filters, by where samples are taken: a sample's place follows the filter, and its weight is the filter's
// sign.
//
// Every sample then belongs to one pixel alone (Ernst et al. 2006), so that no sum crosses a border of tiles. Filters are
// separable. Box and tent are drawn exactly; the others from a table of their absolute value, whose steps the weights do not
// need to know of: it is the filter.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "base/vec.h"

namespace occam::render {

enum class FilterKind : std::uint8_t { Box, Tent, Gaussian, BlackmanHarris, Mitchell };
inline constexpr FilterKind kAllFilters[] = {FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian,
                                             FilterKind::BlackmanHarris, FilterKind::Mitchell};
std::string_view filter_name(FilterKind kind) noexcept;

/// Half the width that suits a filter, in pixels: 0.5, 1, 1.5, 1.65, 2.
float usual_radius(FilterKind kind) noexcept;

class PixelFilter {
public:
    /// radius   half the width in pixels; 0: the usual one
    explicit PixelFilter(FilterKind kind, float radius = 0);

    struct Place {
        Vec2f offset;  ///< from the middle of the pixel, in pixels
        float weight;  ///< 1 or -1
    };
    /// `square` uniform in [0, 1).
    Place place(Vec2f square) const noexcept;

    /// The filter along one axis, not normalised; x in pixels from its middle.
    float value(float x) const noexcept;
    float radius() const noexcept { return radius_; }

private:
    static constexpr int kSteps = 256;

    FilterKind kind_;
    float radius_;
    std::array<float, kSteps + 1> sums_{};  ///< of the absolute value, from 0 to 1
};

}  // namespace occam::render
