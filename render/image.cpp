#include "render/image.h"

#include <bit>
#include <cstdint>
#include <set>
#include <span>
#include <string>

#include "base/error_without_file.h"
#include "base/hash.h"
#include "render/layers.h"
#include "render/picture_formats.h"

namespace occam::render {

const Layer* Image::find(std::string_view name) const noexcept
{
    for (const Layer& layer : layers_)
        if (layer.name == name) return &layer;
    return nullptr;
}

Layer& Image::add_layer(std::string name, std::vector<std::string> channels, bool full_float)
{
    Layer layer{std::move(name), std::move(channels), full_float, {}};
    if (width < 0 || height < 0) throw error_without_file("the sides of an image must be 0 or more", "image");
    const std::size_t pixels = std::size_t(width) * std::size_t(height), channel_count = layer.channel_count();
    if (pixels > 0 && channel_count > layer.pixels.max_size() / pixels)
        throw error_without_file("a layer has more values than can be counted", "image");
    layer.pixels.resize(channel_count * pixels);
    return layers_.emplace_back(std::move(layer));
}

std::uint64_t Image::checksum() const
{
    std::uint64_t h = kFnvStart;
    const Layer* beauty = find("beauty");
    if (!beauty) return h;
    if (const std::string why = why_incomplete(*this, *beauty); !why.empty()) throw error_without_file(why, "image");
    const auto colors = color_channels(*beauty);
    if (!colors) return h;
    for (std::size_t i = 0; i < beauty->pixels.size(); i += beauty->channel_count())
        for (const std::size_t c : colors->rgb) {
            const auto bits = std::bit_cast<std::uint32_t>(beauty->pixels[i + c]);
            const unsigned char bytes[4] = {static_cast<unsigned char>(bits), static_cast<unsigned char>(bits >> 8),
                                            static_cast<unsigned char>(bits >> 16), static_cast<unsigned char>(bits >> 24)};
            h = fnv1a(bytes, 4, h);
        }
    return h;
}

std::string channel_in_file(const Layer& layer, const std::string& channel)
{
    return layer.name == "beauty" ? channel : layer.name + "." + channel;
}

std::string why_not_written(std::span<const Layer> layers)
{
    constexpr std::size_t kLongest = 255;  // characters that OpenEXR takes
    std::set<std::string> known;
    for (const Layer& layer : layers) {
        const std::string of = "layer '" + layer.name + "' ";
        if (layer.name.empty()) return of + "has no name";
        for (const std::string& channel : layer.channels) {
            const std::string name = channel_in_file(layer, channel), its = of + "has a channel '" + channel + "', ";
            if (channel.empty()) return of + "has a channel without a name";
            if (channel.find('.') != std::string::npos) return its + "whose name has a dot: it would be another layer's";
            if (name.find('\0') != std::string::npos) return its + "whose full name has a zero byte";
            if (name.size() > kLongest)
                return its + "whose full name has more than " + std::to_string(kLongest) + " characters";
            if (!known.insert(name).second) return its + "as another layer of that name has, or itself";
        }
    }
    return {};
}

}  // namespace occam::render
