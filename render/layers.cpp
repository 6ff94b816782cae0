#include "render/layers.h"

#include <algorithm>
#include <string_view>

namespace occam::render {
namespace {

constexpr std::string_view kColors[] = {"R", "G", "B"};

std::optional<std::size_t> channel_of(const Layer& layer, std::string_view name)
{
    const auto found = std::find(layer.channels.begin(), layer.channels.end(), name);
    if (found == layer.channels.end()) return std::nullopt;
    return static_cast<std::size_t>(found - layer.channels.begin());
}

// Returns the channel that is the grey of a layer without R, G and B.
std::optional<std::size_t> grey_channel(const Layer& layer, std::optional<std::size_t> alpha)
{
    const std::size_t others = layer.channel_count() - (alpha ? 1 : 0);
    if (others == 1) return alpha == std::size_t(0) ? 1 : 0;
    constexpr std::string_view kNotBesideGrey[] = {"R", "G", "B", "X", "RY", "BY"};
    for (const std::string_view name : kNotBesideGrey)
        if (channel_of(layer, name)) return std::nullopt;
    return channel_of(layer, "Y");
}

}  // namespace

std::optional<ColorChannels> color_channels(const Layer& layer)
{
    const std::optional<std::size_t> alpha = channel_of(layer, "A");
    const auto r = channel_of(layer, "R"), g = channel_of(layer, "G"), b = channel_of(layer, "B");
    if (r && g && b) return ColorChannels{{*r, *g, *b}, alpha};
    if (const auto grey = grey_channel(layer, alpha)) return ColorChannels{{*grey, *grey, *grey}, alpha};
    return std::nullopt;
}

std::string why_without_colors(const Layer& layer)
{
    if (color_channels(layer)) return {};
    std::string missing;
    for (const std::string_view name : kColors)
        if (!channel_of(layer, name)) missing.append(missing.empty() ? "" : ", ").append(name);
    return "layer " + layer.name + " lacks " + missing + ": colours are R, G and B, and grey is Y or a single channel";
}

std::string why_incomplete(const Image& image, const Layer& layer)
{
    const std::size_t channels = layer.channel_count(), values = layer.pixels.size();
    if (image.width >= 0 && image.height >= 0) {
        const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
        if (channels == 0 ? values == 0 : values % channels == 0 && values / channels == pixels) return {};
    }
    return "layer " + layer.name + " does not hold a value of each channel for each pixel";
}

std::string why_incomplete(const Image& image)
{
    for (const Layer& layer : image.layers())
        if (std::string why = why_incomplete(image, layer); !why.empty()) return why;
    return {};
}

}  // namespace occam::render
