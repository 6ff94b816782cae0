// Jittered strata: where the samples of a pixel lie, and those of its lights.
//
// A number depends on (seed, pixel, sample, dimension) alone, so a sample can be drawn again at any time by anyone. Strata
// of different dimensions are paired by permutations of their own (Kensler 2013), so no two dimensions are correlated.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "scenegraph/base/hash.h"
#include "scenegraph/base/vec.h"

namespace occam::render {

/// What a random number is for: the place in the pixel, or one light at one layer of blended surfaces.
struct Dimension {
    std::uint32_t value;

    static constexpr Dimension pixel() noexcept { return {0}; }
    /// Three in a row for each light of each layer: the square takes two.
    static constexpr Dimension light(int layer, int light) noexcept
    {
        return {1 + 3 * (static_cast<std::uint32_t>(layer) * 0x10000u + static_cast<std::uint32_t>(light))};
    }
    constexpr Dimension next(std::uint32_t n) const noexcept { return {value + n}; }
};

/// Position of `index` in a pseudo-random permutation of 0 .. count - 1 that `key` chooses.
inline std::uint32_t permute(std::uint32_t index, std::uint32_t count, std::uint64_t key) noexcept
{
    if (count < 2) return 0;
    // Bijections of the next power of two, walked until the value is in range again.
    const std::uint32_t mask = std::bit_ceil(count) - 1;
    const int half = std::max(1, std::popcount(mask) / 2);
    const auto a = static_cast<std::uint32_t>(key), b = static_cast<std::uint32_t>(key >> 32);
    do {
        // The sum and the factor of a round use different bits, so that each place is equally likely.
        for (const std::uint32_t k : {a, b, std::rotl(a, 11) ^ std::rotl(b, 21)}) {
            index = (index + k) & mask;
            index ^= index >> half;
            index = (index * ((k >> 15) | 1u)) & mask;
            index ^= index >> half;
        }
    } while (index >= count);
    return index;
}

/// Uniform in [0, 1): the top 24 bits, all of which a float can hold.
inline float unit_float(std::uint64_t bits) noexcept { return static_cast<float>(bits >> 40) * 0x1p-24f; }

class Sampler {
public:
    /// samples   a pixel; jitter false: the middle of the pixel, whatever the sample
    Sampler(std::uint64_t seed, int samples, bool jitter) noexcept
        : seed_(mix_bits(seed + 0x9e3779b97f4a7c15ull)), samples_(static_cast<std::uint32_t>(samples)), jitter_(jitter)
    {
    }

    /// Place in the pixel, [0, 1) from its top left corner.
    Vec2f in_pixel(int x, int y, int sample) const noexcept
    {
        return jitter_ ? square(x, y, static_cast<std::uint32_t>(sample), samples_, Dimension::pixel()) : Vec2f(0.5f);
    }

    /// Number `index` of `count` that share the unit interval, one a stratum.
    float interval(int x, int y, std::uint32_t index, std::uint32_t count, Dimension dimension) const noexcept
    {
        const std::uint64_t key = pixel_key(x, y, dimension);
        const float stratum = static_cast<float>(permute(index, count, key));
        return below_one((stratum + unit_float(mix_bits(key + index + 1))) / static_cast<float>(count));
    }

    /// Number `index` of `count` that share the unit square: one a cell of the squarest grid with that many cells or a
    /// few more (which ones stay empty differs from pixel to pixel).
    Vec2f square(int x, int y, std::uint32_t index, std::uint32_t count, Dimension dimension) const noexcept
    {
        std::uint32_t columns = 1;
        while (columns * columns < count) ++columns;
        const std::uint32_t rows = (count + columns - 1) / columns;
        const std::uint64_t key = pixel_key(x, y, dimension);
        const std::uint32_t cell = permute(index, columns * rows, key);
        const std::uint64_t bits = mix_bits(key + index + 1);
        return {below_one((float(cell % columns) + unit_float(bits)) / float(columns)),
                below_one((float(cell / columns) + unit_float(mix_bits(bits))) / float(rows))};
    }

    int samples() const noexcept { return static_cast<int>(samples_); }

private:
    std::uint64_t pixel_key(int x, int y, Dimension dimension) const noexcept
    {
        const auto pixel = (std::uint64_t(static_cast<std::uint32_t>(y)) << 32) | static_cast<std::uint32_t>(x);
        return mix_bits(mix_bits(seed_ ^ pixel) + dimension.value * 0xd1342543de82ef95ull);
    }
    // (n - 1 + u) / n may round up to 1.
    static float below_one(float x) noexcept { return x < 1 ? x : 0x1.fffffep-1f; }

    std::uint64_t seed_;
    std::uint32_t samples_;
    bool jitter_;
};

}  // namespace occam::render
