#include "render/display.h"

#include <algorithm>
#include <cmath>

#include "base/error_without_file.h"
#include "base/luminance.h"
#include "base/maths.h"
#include "render/layers.h"

namespace occam::render {
namespace {

// Returns the curve of Narkowicz 2015, "ACES filmic tone mapping curve".
float aces(float x) noexcept { return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f); }

// The curve is rational with a toe and a shoulder: its slope is kToe at black, and it passes through (kJoin, kJoin) and
// reaches white at kWhite. Below kJoin it is a quadratic polynomial; above, it is the hyperbola that meets the polynomial
// with the same slope and reaches 1 at kWhite.
constexpr float kToe = 0.75f, kJoin = 0.3f, kWhite = 8;
float filmic(float x) noexcept
{
    if (x >= kWhite) return 1;
    if (x < kJoin) return x * (kToe + (1 - kToe) / kJoin * x);
    // With d = x - kJoin, the curve is kJoin + s d / (1 + c d), where s is the slope at the join and c makes it end at 1.
    constexpr float kSlope = 2 - kToe, kRange = kWhite - kJoin, kBend = (kSlope * kRange / (1 - kJoin) - 1) / kRange;
    const float d = x - kJoin;
    return kJoin + kSlope * d / (1 + kBend * d);
}

// The curve is applied to the largest channel, and the others keep their ratio to it, so that the hue stays. What the
// shoulder takes away from a bright colour turns into white, as on film and in the eye.
Vec3f filmic_color(Vec3f color) noexcept
{
    const float peak = std::max({color.x, color.y, color.z});
    if (!(peak > 0)) return Vec3f(0);
    const float shown_peak = filmic(peak);
    const float whiteness = 1 - 1 / (0.15f * std::max(0.0f, peak - shown_peak) + 1);
    const Vec3f same_hue = color * (shown_peak / peak);
    return same_hue + (Vec3f(shown_peak) - same_hue) * whiteness;
}

Vec3f shown(Vec3f color, Tonemap tonemap) noexcept
{
    for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], 1e6f) : 0;  // NaN is black
    switch (tonemap) {
        case Tonemap::None:
        case Tonemap::Srgb:
            break;
        case Tonemap::Aces:
            color = Vec3f(aces(color.x), aces(color.y), aces(color.z));
            break;
        case Tonemap::Filmic:
            color = filmic_color(color);
            break;
    }
    for (int c = 0; c < 3; ++c) {
        color[c] = std::min(color[c], 1.0f);
        if (tonemap != Tonemap::None) color[c] = srgb_from_linear(color[c]);
    }
    return color;
}

constexpr float kKey = 0.25f, kFreeStops = 1, kLitStops = 10, kBrightest = 2;

Vec3f color_at(const float* pixel, const ColorChannels& colors) noexcept
{
    return {pixel[colors.rgb[0]], pixel[colors.rgb[1]], pixel[colors.rgb[2]]};
}

// Returns the logarithms to base 2 of the luminances of pixels that something covers.
std::vector<float> log_luminances(const Layer& beauty, const ColorChannels& colors)
{
    std::vector<float> logs;
    const std::size_t channels = beauty.channel_count();
    for (std::size_t i = 0; i + channels <= beauty.pixels.size(); i += channels) {
        const float* p = &beauty.pixels[i];
        const float alpha = colors.alpha ? p[*colors.alpha] : 1.0f;
        const float y = luminance(color_at(p, colors)) / alpha;
        if (alpha >= 0.5f && y > 0 && std::isfinite(y)) logs.push_back(maths::log2(y));
    }
    return logs;
}

}  // namespace

float srgb_from_linear(float x) noexcept { return x <= 0.0031308f ? 12.92f * x : 1.055f * maths::pow(x, 1 / 2.4f) - 0.055f; }

float linear_from_srgb(float x) noexcept { return x <= 0.04045f ? x / 12.92f : maths::pow((x + 0.055f) / 1.055f, 2.4f); }

float automatic_exposure(const Image& image)
{
    const Layer* beauty = image.find("beauty");
    const auto colors = beauty ? color_channels(*beauty) : std::nullopt;
    if (!image.is_light || !colors) return 0;
    const std::vector<float> logs = log_luminances(*beauty, *colors);
    if (logs.empty()) return 0;
    std::vector<float> order = logs;
    const auto bright = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) * 99 / 100);
    std::nth_element(order.begin(), bright, order.end());
    double sum = 0;
    std::size_t count = 0;
    for (const float l : logs)
        if (l >= *bright - kLitStops) sum += double(l), ++count;
    const float off = static_cast<float>(sum / double(count)) - maths::log2(kKey);  // stops too bright
    if (off > kFreeStops) return -std::min(off - kFreeStops, kMostStops);
    if (off >= -kFreeStops) return 0;
    return std::clamp(maths::log2(kBrightest) - *bright, 0.0f, std::min(-off - kFreeStops, kMostStops));
}

DisplayImage display_image(const Image& image, const WriteOptions& options, float most)
{
    DisplayImage out;
    const Layer* beauty = image.find("beauty");
    const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
    const auto colors = beauty ? color_channels(*beauty) : std::nullopt;
    if (!colors) throw error_without_file(beauty ? why_without_colors(*beauty) : "there is no layer beauty", "image");
    const std::size_t from = beauty->channel_count();
    // Sums of the coverages of several surfaces may come to a little less than 1.
    const float opaque = 1 - 0.5f / most;
    for (std::size_t i = 0; colors->alpha && i < pixels && out.channels == 3; ++i)
        if (beauty->pixels[i * from + *colors->alpha] < opaque) out.channels = 4;

    const float gain = maths::exp2(options.exposure_ev ? *options.exposure_ev : automatic_exposure(image));
    const Tonemap tonemap = image.is_light || options.tonemap == Tonemap::None ? options.tonemap : Tonemap::Srgb;
    const auto to = static_cast<std::size_t>(out.channels);
    out.pixels.resize(to * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* p = &beauty->pixels[i * from];
        const float alpha = to == 4 ? std::clamp(p[*colors->alpha], 0.0f, 1.0f) : 1.0f;
        const float scale = alpha > 0 ? gain / alpha : 0;
        const Vec3f color = shown(color_at(p, *colors) * scale, tonemap);
        for (int c = 0; c < 3; ++c) out.pixels[i * to + std::size_t(c)] = color[c];
        if (to == 4) out.pixels[i * to + 3] = alpha;
    }
    return out;
}

}  // namespace occam::render
