#include "render/compare.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "base/error_without_file.h"
#include "render/layers.h"

namespace occam::render {
namespace {

constexpr const char* kOtherChannels = "the layer has different channels in the two pictures";

// The channels of a layer that are compared.
struct Channels {
    const Layer* layer = nullptr;  // null: there are none of that name
    std::vector<std::size_t> which{};

    float value(std::size_t pixel, std::size_t channel) const
    {
        return layer->pixels[pixel * layer->channel_count() + which[channel]];
    }
    const std::string& name(std::size_t channel) const { return layer->channels[which[channel]]; }
};

// Returns the channels of beauty that are compared: its colours, or all but alpha if it has none.
std::vector<std::size_t> colors_of(const Layer& beauty)
{
    const auto colors = color_channels(beauty);
    if (colors && colors->is_grey()) return {colors->rgb[0]};
    if (colors) return {colors->rgb.begin(), colors->rgb.end()};
    std::vector<std::size_t> all;
    for (std::size_t c = 0; c < beauty.channel_count(); ++c)
        if (beauty.channels[c] != "A") all.push_back(c);
    return all;
}

Channels channels_of(const Image& image, std::string_view name)
{
    const Layer* const layer = image.find(name);
    if (layer && name == "beauty") return {layer, colors_of(*layer)};
    if (layer) {
        std::vector<std::size_t> all(layer->channel_count());
        std::iota(all.begin(), all.end(), std::size_t(0));
        return {layer, std::move(all)};
    }
    const Layer* const beauty = name == kAlphaOfBeauty ? image.find("beauty") : nullptr;
    if (!beauty) return {};
    const auto alpha = std::find(beauty->channels.begin(), beauty->channels.end(), "A");
    if (alpha == beauty->channels.end()) return {};
    return {beauty, {static_cast<std::size_t>(alpha - beauty->channels.begin())}};
}

struct Pair {
    Channels a, b;
    std::size_t pixels;

    std::size_t channels() const { return b.which.size(); }
    bool has_same_channels() const
    {
        if (a.which.size() != b.which.size()) return false;
        for (std::size_t c = 0; c < channels(); ++c)
            if (a.name(c) != b.name(c)) return false;
        return true;
    }
};

// Returns the rectangle of a picture's pixels, and the frame in which it lies.
std::string place_of(const Image& image)
{
    const auto pair = [](int x, const char* between, int y) { return std::to_string(x) + between + std::to_string(y); };
    return pair(image.width, "x", image.height) + " pixels from " + pair(image.x0, ",", image.y0) + " of a frame of " +
           pair(image.full_width, "x", image.full_height);
}

bool is_whole(const Image& image)
{
    return image.x0 == 0 && image.y0 == 0 && image.full_width == image.width && image.full_height == image.height;
}

void check_places(const Image& a, const Image& b)
{
    for (const Image* image : {&a, &b})
        if (const std::string why = why_incomplete(*image); !why.empty()) throw error_without_file(why);
    if (a.width != b.width || a.height != b.height)
        throw error_without_file("pictures of different sizes cannot be compared: " + std::to_string(a.width) + "x" +
                                 std::to_string(a.height) + " and " + std::to_string(b.width) + "x" +
                                 std::to_string(b.height));
    // Most formats cannot say that a picture is a part of a frame.
    const bool may_be_same = is_whole(a) || is_whole(b);
    if (!may_be_same && (a.x0 != b.x0 || a.y0 != b.y0 || a.full_width != b.full_width || a.full_height != b.full_height))
        throw error_without_file("pictures of different parts of a frame cannot be compared: " + place_of(a) + ", and " +
                                 place_of(b));
}

Pair pair_of(const Image& a, const Image& b, const std::string& name)
{
    check_places(a, b);
    Pair pair{channels_of(a, name), channels_of(b, name), std::size_t(a.width) * std::size_t(a.height)};
    if (!pair.a.layer || !pair.b.layer) throw error_without_file("only one of the pictures has the layer", name);
    return pair;
}

Pair comparable_pair_of(const Image& a, const Image& b, const std::string& name)
{
    Pair pair = pair_of(a, b, name);
    if (!pair.has_same_channels()) throw error_without_file(kOtherChannels, name);
    return pair;
}

// Returns nothing if the two values cannot be compared.
std::optional<double> difference(float a, float b)
{
    if (std::isnan(a) || std::isnan(b)) return std::nullopt;
    if (std::isinf(a) || std::isinf(b)) return a == b ? std::optional(0.0) : std::nullopt;
    return double(a) - double(b);
}

// Returns the largest absolute difference of a pixel's channels.
std::optional<double> largest_difference(const Pair& p, std::size_t pixel)
{
    double largest = 0;
    for (std::size_t c = 0; c < p.channels(); ++c) {
        const auto d = difference(p.a.value(pixel, c), p.b.value(pixel, c));
        if (!d) return std::nullopt;
        largest = std::max(largest, std::fabs(*d));
    }
    return largest;
}

// Returns what is known of a layer of which no pixel can be compared.
Difference no_figures(const Pair& p, const std::string& name)
{
    Difference none;
    none.layer = name;
    none.has_other_channels = !p.has_same_channels();
    none.pixels = none.incomparable = p.pixels;
    none.mse = none.rmse = none.rel_mse = none.psnr = none.max = none.p999 = std::numeric_limits<double>::quiet_NaN();
    return none;
}

// Returns the value of that rank, counted from 1, among the largest differences of all pixels that can be compared. It finds
// 16 bits of it at a time, since a list of the differences would take more memory than some of the pictures: the bits of
// numbers that are not negative are in the order of the numbers.
double ranked_difference(const Pair& p, std::size_t rank)
{
    constexpr unsigned kBits = 16;
    std::uint64_t known = 0;
    for (unsigned shift = 64; shift > 0;) {
        const unsigned above = std::exchange(shift, shift - kBits);
        std::vector<std::size_t> counts(std::size_t(1) << kBits);
        for (std::size_t i = 0; i < p.pixels; ++i) {
            const auto most = largest_difference(p, i);
            if (!most) continue;
            const auto bits = std::bit_cast<std::uint64_t>(*most);
            if (above == 64 || bits >> above == known) ++counts[bits >> shift & ((1u << kBits) - 1)];
        }
        std::size_t next = 0;
        while (rank > counts[next]) rank -= counts[next++];
        known = known << kBits | next;
    }
    return std::bit_cast<double>(known);
}

Difference difference_of(const Pair& p, const std::string& name)
{
    Difference out;
    out.layer = name;
    out.pixels = p.pixels;
    double squares = 0, relative = 0;
    for (std::size_t i = 0; i < p.pixels; ++i) {
        const auto most = largest_difference(p, i);
        if (!most) {
            ++out.incomparable;
            continue;
        }
        out.max = std::max(out.max, *most);
        for (std::size_t c = 0; c < p.channels(); ++c) {
            const float b = p.b.value(i, c);
            if (std::isinf(b)) continue;
            const double d = *difference(p.a.value(i, c), b);
            squares += d * d;
            relative += d * d / (double(b) * double(b) + 0.01);
        }
    }
    const std::uint64_t compared = out.pixels - out.incomparable;
    if (compared == 0) return no_figures(p, name);
    const double values = double(compared) * double(p.channels());
    out.mse = squares / values;
    out.rmse = std::sqrt(out.mse);
    out.rel_mse = relative / values;
    out.psnr = out.mse > 0 ? -10 * std::log10(out.mse) : std::numeric_limits<double>::infinity();
    const auto rank = static_cast<std::size_t>(std::ceil(0.999 * double(compared)));
    out.p999 = ranked_difference(p, std::clamp<std::size_t>(rank, 1, compared));
    return out;
}

}  // namespace

Difference compare(const Image& a, const Image& reference, const std::string& name)
{
    return difference_of(comparable_pair_of(a, reference, name), name);
}

std::vector<Difference> compare(const Image& a, const Image& reference)
{
    check_places(a, reference);
    std::vector<std::string> names{"beauty", std::string(kAlphaOfBeauty)};
    for (const Layer& layer : a.layers())
        if (std::find(names.begin(), names.end(), layer.name) == names.end()) names.push_back(layer.name);
    std::vector<Difference> all;
    for (const std::string& name : names) {
        if (!channels_of(a, name).layer || !channels_of(reference, name).layer) continue;
        const Pair pair = pair_of(a, reference, name);
        all.push_back(pair.has_same_channels() ? difference_of(pair, name) : no_figures(pair, name));
    }
    if (all.empty()) throw error_without_file("the pictures have no layer in common");
    return all;
}

Image heat_map(const Image& a, const Image& reference, const std::string& name, double scale)
{
    const Pair p = comparable_pair_of(a, reference, name);
    Image heat(a.width, a.height);
    heat.is_light = false;
    Layer& beauty = heat.add_layer("beauty", {"R", "G", "B"});
    for (std::size_t i = 0; i < p.pixels; ++i) {
        const auto most = largest_difference(p, i);
        float* out = &beauty.pixels[3 * i];
        if (!most) {
            out[0] = out[2] = 1;
            continue;
        }
        const double t = scale > 0 ? std::min(*most / scale, 1.0) : (*most > 0 ? 1.0 : 0.0);
        for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(std::clamp(3 * t - c, 0.0, 1.0));
    }
    return heat;
}

}  // namespace occam::render
