#include "render/image.h"

#include <bit>

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
    layer.pixels.resize(layer.channel_count() * std::size_t(width) * std::size_t(height));
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
