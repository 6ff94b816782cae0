#include "render/display.h"

#include <algorithm>

#include "base/maths.h"

namespace occam::render {
namespace {

// Narkowicz 2015, "ACES filmic tone mapping curve".
float aces(float x) noexcept { return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f); }

float shown(float x, Tonemap tonemap) noexcept
{
    if (!(x > 0)) return 0;  // NaN too
    if (tonemap == Tonemap::Aces) x = aces(std::min(x, 1e6f));
    x = std::min(x, 1.0f);
    return tonemap == Tonemap::None ? x : srgb_from_linear(x);
}

}  // namespace

float srgb_from_linear(float x) noexcept { return x <= 0.0031308f ? 12.92f * x : 1.055f * maths::pow(x, 1 / 2.4f) - 0.055f; }

float linear_from_srgb(float x) noexcept { return x <= 0.04045f ? x / 12.92f : maths::pow((x + 0.055f) / 1.055f, 2.4f); }

DisplayImage display_image(const Image& image, const WriteOptions& options)
{
    DisplayImage out;
    const Layer* beauty = image.find("beauty");
    const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
    if (!beauty || beauty->channel_count() < 3) {
        out.pixels.resize(3 * pixels);
        return out;
    }
    const std::size_t from = beauty->channel_count();
    const bool has_alpha = from >= 4;
    for (std::size_t i = 0; has_alpha && i < pixels && out.channels == 3; ++i)
        if (beauty->pixels[i * from + 3] < 1) out.channels = 4;

    const float gain = maths::exp2(options.exposure_ev);
    const auto to = static_cast<std::size_t>(out.channels);
    out.pixels.resize(to * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* p = &beauty->pixels[i * from];
        const float alpha = to == 4 ? std::clamp(p[3], 0.0f, 1.0f) : 1.0f;
        const float scale = alpha > 0 ? gain / alpha : 0;
        for (std::size_t c = 0; c < 3; ++c) out.pixels[i * to + c] = shown(p[c] * scale, options.tonemap);
        if (to == 4) out.pixels[i * to + 3] = alpha;
    }
    return out;
}

}  // namespace occam::render
