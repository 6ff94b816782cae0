#include "render/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error_without_file.h"

namespace occam::render {
namespace {

struct Pair {
    const Layer& a;
    const Layer& b;
    std::size_t stride_a, stride_b, channels, pixels;
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

Pair pair_of(const Image& a, const Image& b, const std::string& name)
{
    if (a.width != b.width || a.height != b.height)
        throw error_without_file("pictures of different sizes cannot be compared: " + std::to_string(a.width) + "x" +
                                 std::to_string(a.height) + " and " + std::to_string(b.width) + "x" +
                                 std::to_string(b.height));
    // Most formats cannot say that a picture is a part of a frame.
    const bool may_be_same = is_whole(a) || is_whole(b);
    if (!may_be_same && (a.x0 != b.x0 || a.y0 != b.y0 || a.full_width != b.full_width || a.full_height != b.full_height))
        throw error_without_file("pictures of different parts of a frame cannot be compared: " + place_of(a) + ", and " +
                                 place_of(b));
    const Layer* la = a.find(name);
    const Layer* lb = b.find(name);
    if (!la || !lb) throw error_without_file("only one of the pictures has the layer", name);
    const std::size_t limit = name == "beauty" ? 3 : std::numeric_limits<std::size_t>::max();
    const std::size_t channels = std::min(limit, la->channel_count());
    if (channels != std::min(limit, lb->channel_count()) ||
        !std::equal(la->channels.begin(), la->channels.begin() + std::ptrdiff_t(channels), lb->channels.begin()))
        throw error_without_file("the layer has different channels in the two pictures", name);
    return {*la, *lb, la->channel_count(), lb->channel_count(), channels, std::size_t(a.width) * std::size_t(a.height)};
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
    for (std::size_t c = 0; c < p.channels; ++c) {
        const auto d = difference(p.a.pixels[pixel * p.stride_a + c], p.b.pixels[pixel * p.stride_b + c]);
        if (!d) return std::nullopt;
        largest = std::max(largest, std::fabs(*d));
    }
    return largest;
}

}  // namespace

Difference compare(const Image& a, const Image& reference, const std::string& name)
{
    const Pair p = pair_of(a, reference, name);
    Difference out;
    out.layer = name;
    out.pixels = p.pixels;
    std::vector<double> largest;
    double squares = 0, relative = 0;
    for (std::size_t i = 0; i < p.pixels; ++i) {
        const auto most = largest_difference(p, i);
        if (!most) {
            ++out.incomparable;
            continue;
        }
        largest.push_back(*most);
        for (std::size_t c = 0; c < p.channels; ++c) {
            const float b = p.b.pixels[i * p.stride_b + c];
            if (std::isinf(b)) continue;
            const double d = *difference(p.a.pixels[i * p.stride_a + c], b);
            squares += d * d;
            relative += d * d / (double(b) * double(b) + 0.01);
        }
    }
    if (largest.empty()) return out;
    const double values = double(largest.size()) * double(p.channels);
    out.mse = squares / values;
    out.rmse = std::sqrt(out.mse);
    out.rel_mse = relative / values;
    out.psnr = out.mse > 0 ? -10 * std::log10(out.mse) : std::numeric_limits<double>::infinity();
    const auto rank = static_cast<std::size_t>(std::ceil(0.999 * double(largest.size())));
    const auto nth = largest.begin() + std::ptrdiff_t(std::clamp<std::size_t>(rank, 1, largest.size()) - 1);
    std::nth_element(largest.begin(), nth, largest.end());
    out.p999 = *nth;
    out.max = *std::max_element(nth, largest.end());
    return out;
}

std::vector<Difference> compare(const Image& a, const Image& reference)
{
    std::vector<Difference> all;
    for (const Layer& layer : a.layers())
        if (reference.find(layer.name)) all.push_back(compare(a, reference, layer.name));
    if (all.empty()) throw error_without_file("the pictures have no layer in common");
    std::stable_partition(all.begin(), all.end(), [](const Difference& d) { return d.layer == "beauty"; });
    return all;
}

Image heat_map(const Image& a, const Image& reference, const std::string& name, double scale)
{
    const Pair p = pair_of(a, reference, name);
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
