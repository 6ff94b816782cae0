// Differences between two pictures.
//
// Figures are means over all channels of all pixels that can be compared, in double. A pixel that is NaN in either
// picture, or infinite in only one, cannot be compared and is counted. A pixel that is infinite in both alike is equal.
// Where no pixel can be compared, the figures are NaN.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/image.h"

namespace occam::render {

/// What the alpha of the picture is called among the layers: it is measured by itself, so that the figures of beauty are
/// those of its colours.
inline constexpr std::string_view kAlphaOfBeauty = "beauty.A";

struct Difference {
    std::string layer;
    bool has_other_channels = false;  ///< the pictures have other channels there; no pixel can be compared
    std::uint64_t pixels = 0;
    std::uint64_t incomparable = 0;  ///< pixels that are left out of the figures below
    double mse = 0, rmse = 0;
    double rel_mse = 0;  ///< mean of (a - b)^2 / (b^2 + 0.01), where b is the reference (Rousselle et al. 2011, sec. 5)
    double psnr = 0;     ///< in dB, for a peak of 1; infinity if the pictures are equal
    double max = 0;      ///< largest absolute difference
    double p999 = 0;     ///< 99.9th percentile of a pixel's largest absolute difference (nearest rank)
};

/// Compares two layers with the same channels (of beauty only the colours: R, G and B, or the grey), or the alpha of both
/// pictures (kAlphaOfBeauty). Throws Error if channels, sizes or places in the frame differ, or a layer of either picture
/// does not hold a value of each channel for each pixel.
Difference compare(const Image& a, const Image& reference, const std::string& layer);

/// Compares every layer that both pictures have, beauty first and then its alpha. A layer whose channels differ has no
/// figures. Throws Error if sizes or places in the frame differ, no layer is common, or a layer lacks values.
std::vector<Difference> compare(const Image& a, const Image& reference);

/// Returns the layer's largest absolute difference at each pixel as a colour, from black for none through red and yellow
/// to white at `scale` and above. Pixels that cannot be compared are magenta.
Image heat_map(const Image& a, const Image& reference, const std::string& layer, double scale);

/// Returns a JSON array with one object per layer.
std::string to_json(const std::vector<Difference>& differences);

}  // namespace occam::render
