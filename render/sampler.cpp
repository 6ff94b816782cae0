#include "render/sampler.h"

namespace occam::render {
namespace {

std::uint32_t reversed(std::uint32_t x) noexcept
{
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

// The top 24 bits, all of which a float can hold.
float unit_float(std::uint32_t bits) noexcept { return static_cast<float>(bits >> 8) * 0x1p-24f; }

std::uint32_t low(std::uint64_t bits) noexcept { return static_cast<std::uint32_t>(bits); }

// Pascal's triangle modulo 2 as a matrix of bits: entry (k, i) is 1 where k's bits are among i's (Lucas), so each bit of the
// index adds itself to the one that lacks it, one power of two after the other.
std::uint32_t pascal(std::uint32_t x) noexcept
{
    x ^= x >> 16;
    x ^= (x >> 8) & 0x00ff00ffu;
    x ^= (x >> 4) & 0x0f0f0f0fu;
    x ^= (x >> 2) & 0x33333333u;
    return x ^ ((x >> 1) & 0x55555555u);
}

// owen_scramble() of a number whose bits are given, and wanted, in reversed order.
std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) noexcept
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ x * 0x53a22864u;
}

}  // namespace

SobolPair sobol_pair(std::uint32_t index) noexcept { return {reversed(index), reversed(pascal(index))}; }

std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) noexcept { return reversed(scramble_reversed(reversed(x), seed)); }

std::uint64_t Sampler::key_of(int x, int y, Dimension dimension) const noexcept
{
    const auto pixel = (std::uint64_t(static_cast<std::uint32_t>(y)) << 32) | static_cast<std::uint32_t>(x);
    return mix_bits(mix_bits(seed_ ^ pixel) + dimension.value * 0xd1342543de82ef95ull);
}

// Both coordinates are reversed once: what sobol_pair() and owen_scramble() do twice cancels.
Vec2f Sampler::square(int x, int y, std::uint32_t index, Dimension dimension) const noexcept
{
    const std::uint64_t key = key_of(x, y, dimension);
    const std::uint32_t shuffled = owen_scramble(index, low(key));
    return {unit_float(reversed(scramble_reversed(shuffled, low(key >> 32)))),
            unit_float(reversed(scramble_reversed(pascal(shuffled), low(mix_bits(key)))))};
}

float Sampler::interval(int x, int y, std::uint32_t index, Dimension dimension) const noexcept
{
    const std::uint64_t key = key_of(x, y, dimension);
    return unit_float(reversed(scramble_reversed(owen_scramble(index, low(key)), low(key >> 32))));
}

}  // namespace occam::render
