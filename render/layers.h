// What the layers of a picture hold: which of their channels are colours, and whether they have all their values.
//
// All that shows, compares or hashes a picture asks here, so that one rule holds for all formats.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "render/image.h"

namespace occam::render {

/// Says which channels of a layer are its colours. R, G and B are, in any order and beside any others. A layer without them
/// is grey if it has the luminance Y, or a single channel of any name beside A. Y does not count as a luminance if there is
/// a channel X or one of the colours, nor if there are RY and BY, which hold the rest of a colour. No channel but A is
/// alpha.
struct ColorChannels {
    std::array<std::size_t, 3> rgb{};  ///< all the same in a grey layer
    std::optional<std::size_t> alpha{};

    bool is_grey() const noexcept { return rgb[0] == rgb[1]; }
};
/// Returns nothing if the layer has no colours.
std::optional<ColorChannels> color_channels(const Layer& layer);
/// Returns what the layer lacks to have colours, or an empty string if it has them.
std::string why_without_colors(const Layer& layer);

/// Returns what is wrong if a layer does not have as many values as the picture's size and the layer's channels say. Returns
/// an empty string if none is wrong.
std::string why_incomplete(const Image& image, const Layer& layer);
std::string why_incomplete(const Image& image);

}  // namespace occam::render
