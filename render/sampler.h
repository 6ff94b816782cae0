// Sample values: Owen-scrambled Sobol points in pairs of dimensions.
//
// A number depends on (seed, pixel, sample, dimension) alone, so a sample can be drawn again at any time by any thread,
// and a picture may continue from where it stopped. Each dimension is the (0, 2)-sequence of Sobol with its own order and
// scrambling (Burley 2020): every aligned power of two of consecutive samples has one in each elementary interval of that
// size, and no two dimensions are correlated.
#pragma once

#include <cstdint>

#include "base/hash.h"
#include "base/vec.h"

namespace occam::render {

/// Names the purpose of a number, or of a pair of them.
struct Dimension {
    enum class Use : std::uint32_t { Light, LightChoice, Scatter, Lobe, Survival, Passing, Faint };
    std::uint32_t value;

    static constexpr Dimension pixel() noexcept { return {0}; }
    static constexpr Dimension lens() noexcept { return {1}; }
    /// Returns the dimension of the moment at which a sample sees the scene.
    static constexpr Dimension time() noexcept { return {4}; }
    /// Returns the dimension of the number by which ShadowQueue::trace() ends rays.
    static Dimension luck() noexcept { return at(0xffffffffu, Use::Passing, 1); }
    /// Returns the dimension of a use at one of a path's surfaces; `slot` counts the numbers of one use. Different keys
    /// and uses share a dimension once in 2^31.
    static Dimension at(std::uint32_t vertex_key, Use use, std::uint32_t slot = 0) noexcept
    {
        const std::uint64_t word = (std::uint64_t(vertex_key) << 32) | (slot << 4) | static_cast<std::uint32_t>(use);
        return {static_cast<std::uint32_t>(mix_bits(word + 0x632be59bd9b4e019ull) >> 32) | 2u};
    }
};

/// Holds number `index` of the sequence of Sobol's first two dimensions, 32 bits each; any two of the first 2^32 differ.
struct SobolPair {
    std::uint32_t x, y;
};
SobolPair sobol_pair(std::uint32_t index) noexcept;

/// Applies Owen's nested scrambling to the bits of a number: each bit is flipped depending on the bits above it and on
/// the seed, by the hash of Laine and Karras 2011 with the constants of Vegdahl 2021.
std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) noexcept;

/// Holds the numbers of one pixel and dimension: what does not depend on their index is computed once.
class Sequence {
public:
    explicit Sequence(std::uint64_t key) noexcept
        : order_(static_cast<std::uint32_t>(key)),
          flips_x_(static_cast<std::uint32_t>(key >> 32)),
          flips_y_(static_cast<std::uint32_t>(mix_bits(key)))
    {
    }
    /// Returns number `index`, in [0, 1).
    float interval(std::uint32_t index) const noexcept;
    /// Returns the point at `index`; its x is what interval() returns.
    Vec2f square(std::uint32_t index) const noexcept;
    static constexpr int kBlock = 8;
    /// Computes the points first, first + 1, ... of a block.
    void squares(std::uint32_t first, float (&x)[kBlock], float (&y)[kBlock]) const noexcept;

private:
    std::uint32_t order_, flips_x_, flips_y_;
};

/// Names surfaces of paths: pixels, indices of samples and keys.
struct SurfacesToDraw {
    static constexpr int kMost = 8, kLightSlots = 18;
    int x[kMost]{}, y[kMost]{};
    std::uint32_t index[kMost]{}, key[kMost]{};
    std::uint32_t light_slots = 1;  ///< bits of the slots of Use::Light, below kLightSlots, that are drawn
};

/// Holds the numbers of which most surfaces of a path need one each, for several surfaces side by side. It is not
/// initialised.
struct SurfaceNumbers {
    struct Squares {
        alignas(32) float x[SurfacesToDraw::kMost];
        alignas(32) float y[SurfacesToDraw::kMost];
    };
    Squares light[SurfacesToDraw::kLightSlots];  ///< of Use::Light, by their slots
    Squares scatter;
    alignas(32) float lobe[SurfacesToDraw::kMost];
};

/// The seed of all that is found out about a frame before it is made. It does not follow the seed of the picture: pictures
/// of one scene that differ in their seeds alone may be averaged, so what is found out must be the same for all of them.
inline constexpr std::uint64_t kSketchSeed = 0;

class Sampler {
public:
    /// jitter   false: every sample goes through the middle of its pixel
    Sampler(std::uint64_t seed, int samples, bool jitter) noexcept
        : seed_(mix_bits(seed + 0x9e3779b97f4a7c15ull)), samples_(samples), jitter_(jitter)
    {
    }

    /// Returns the place in the pixel, in [0, 1) from its top left corner.
    Vec2f in_pixel(int x, int y, int sample) const noexcept
    {
        return jitter_ ? square(x, y, static_cast<std::uint32_t>(sample), Dimension::pixel()) : Vec2f(0.5f);
    }
    Sequence sequence(int x, int y, Dimension dimension) const noexcept
    {
        return Sequence(key_of(mixed_pixel(x, y), dimension));
    }
    /// Returns several samples' places in their pixels, side by side, in lanes; keys are not read.
    void draw_in_pixels(const SurfacesToDraw& of, Vec2f (&to)[SurfacesToDraw::kMost]) const noexcept;
    /// Draws the numbers of several surfaces side by side, in lanes.
    void draw(const SurfacesToDraw& of, SurfaceNumbers& to) const noexcept;
    float interval(int x, int y, std::uint32_t index, Dimension dimension) const noexcept
    {
        return sequence(x, y, dimension).interval(index);
    }
    Vec2f square(int x, int y, std::uint32_t index, Dimension dimension) const noexcept
    {
        return sequence(x, y, dimension).square(index);
    }

    int samples() const noexcept { return samples_; }

private:
    std::uint64_t mixed_pixel(int x, int y) const noexcept
    {
        return mix_bits(seed_ ^ ((std::uint64_t(static_cast<std::uint32_t>(y)) << 32) | static_cast<std::uint32_t>(x)));
    }
    static std::uint64_t key_of(std::uint64_t mixed_pixel, Dimension dimension) noexcept
    {
        return mix_bits(mixed_pixel + dimension.value * 0xd1342543de82ef95ull);
    }

    std::uint64_t seed_;
    int samples_;
    bool jitter_;
};

namespace sobol {

inline std::uint32_t reversed(std::uint32_t x) noexcept
{
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

// Converts the top 24 bits, all of which a float can hold.
inline float unit_float(std::uint32_t bits) noexcept
{
    return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

// Multiplies by Pascal's triangle modulo 2 as a matrix of bits. Entry (k, i) is 1 where the bits of k are among those of
// i (Lucas), so each bit of the index adds itself to the one that lacks it, one power of two after the other.
inline std::uint32_t pascal(std::uint32_t x) noexcept
{
    x ^= x >> 16;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 2) & 0x33333333u;
    return x ^ ((x >> 1) & 0x55555555u);
}

// Does what owen_scramble() does, for a number whose bits are passed and returned in reversed order.
inline std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) noexcept
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

}  // namespace sobol

inline SobolPair sobol_pair(std::uint32_t index) noexcept
{
    return {sobol::reversed(index), sobol::reversed(sobol::pascal(index))};
}

inline std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) noexcept
{
    return sobol::reversed(sobol::scramble_reversed(sobol::reversed(x), seed));
}

// Both coordinates are reversed only once here, because the reversals in sobol_pair() and owen_scramble() cancel.
inline Vec2f Sequence::square(std::uint32_t index) const noexcept
{
    using namespace sobol;
    const std::uint32_t shuffled = owen_scramble(index, order_);
    return {unit_float(reversed(scramble_reversed(shuffled, flips_x_))),
            unit_float(reversed(scramble_reversed(pascal(shuffled), flips_y_)))};
}

inline float Sequence::interval(std::uint32_t index) const noexcept
{
    return sobol::unit_float(sobol::reversed(sobol::scramble_reversed(owen_scramble(index, order_), flips_x_)));
}

}  // namespace occam::render
