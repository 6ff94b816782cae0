// The numbers that samples are made of: Owen-scrambled Sobol points in pairs of dimensions.
//
// A number depends on (seed, pixel, sample, dimension) alone, so a sample can be drawn again at any time by anyone, and a
// picture may go on from where it stopped. Each dimension is the (0, 2)-sequence of Sobol in an order and with a
// scrambling of its own (Burley 2020): every aligned power of two of consecutive samples has one in each elementary
// interval of that size, and no two dimensions are correlated.
#pragma once

#include <cstdint>

#include "scenegraph/base/hash.h"
#include "scenegraph/base/vec.h"

namespace occam::render {

/// What a number, or a pair of them, is for.
struct Dimension {
    enum class Use : std::uint32_t { Light, LightChoice, Scatter, Lobe, Survival, Passing };
    std::uint32_t value;

    static constexpr Dimension pixel() noexcept { return {0}; }
    static constexpr Dimension lens() noexcept { return {1}; }
    /// At one of a path's surfaces; `slot` counts numbers of one use. Unlike keys and uses share a dimension once in 2^32.
    static Dimension at(std::uint32_t vertex_key, Use use, std::uint32_t slot = 0) noexcept
    {
        const std::uint64_t word = (std::uint64_t(vertex_key) << 32) | (slot << 4) | static_cast<std::uint32_t>(use);
        return {static_cast<std::uint32_t>(mix_bits(word + 0x632be59bd9b4e019ull) >> 32) | 2u};
    }
};

/// Number `index` of the sequence of Sobol's first two dimensions, 32 bits each; any two of the first 2^32 differ.
struct SobolPair {
    std::uint32_t x, y;
};
SobolPair sobol_pair(std::uint32_t index) noexcept;

/// Owen's nested scrambling of a number's bits: each is flipped as the ones above it and the seed say, by the hash of Laine
/// and Karras 2011 with the constants of Vegdahl 2021.
std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) noexcept;

class Sampler {
public:
    /// jitter   false: every sample through the middle of its pixel
    Sampler(std::uint64_t seed, int samples, bool jitter) noexcept
        : seed_(mix_bits(seed + 0x9e3779b97f4a7c15ull)), samples_(samples), jitter_(jitter)
    {
    }

    /// Place in the pixel, [0, 1) from its top left corner.
    Vec2f in_pixel(int x, int y, int sample) const noexcept
    {
        return jitter_ ? square(x, y, static_cast<std::uint32_t>(sample), Dimension::pixel()) : Vec2f(0.5f);
    }
    /// Number `index` of that pixel and dimension, in [0, 1).
    float interval(int x, int y, std::uint32_t index, Dimension dimension) const noexcept;
    /// As a point; x is what interval() gives.
    Vec2f square(int x, int y, std::uint32_t index, Dimension dimension) const noexcept;

    int samples() const noexcept { return samples_; }

private:
    std::uint64_t key_of(int x, int y, Dimension dimension) const noexcept;

    std::uint64_t seed_;
    int samples_;
    bool jitter_;
};

}  // namespace occam::render
