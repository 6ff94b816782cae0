#include "render/image.h"

#include <bit>

#include "base/error_without_file.h"
#include "base/hash.h"

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

std::uint64_t Image::checksum() const noexcept
{
    std::uint64_t h = kFnvStart;
    const Layer* beauty = find("beauty");
    if (!beauty || beauty->channel_count() < 3) return h;
    for (std::size_t i = 0; i < beauty->pixels.size(); i += beauty->channel_count())
        for (std::size_t c = 0; c < 3; ++c) {
            const auto bits = std::bit_cast<std::uint32_t>(beauty->pixels[i + c]);
            const unsigned char bytes[4] = {static_cast<unsigned char>(bits), static_cast<unsigned char>(bits >> 8),
                                            static_cast<unsigned char>(bits >> 16), static_cast<unsigned char>(bits >> 24)};
            h = fnv1a(bytes, 4, h);
        }
    return h;
}

}  // namespace occam::render
