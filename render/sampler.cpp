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

}  // namespace

SobolPair sobol_pair(std::uint32_t index) noexcept
{
    // Direction numbers of the second dimension: rows of Pascal's triangle modulo 2, each from the one before.
    std::uint32_t y = 0;
    std::uint32_t direction = 1u << 31;
    for (std::uint32_t i = index; i != 0; i >>= 1) {
        if (i & 1u) y ^= direction;
        direction ^= direction >> 1;
    }
    return {reversed(index), y};
}

std::uint32_t owen_scramble(std::uint32_t x, std::uint32_t seed) noexcept
{
    x = reversed(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reversed(x);
}

Vec2f Sampler::square(int x, int y, std::uint32_t index, Dimension dimension) const noexcept
{
    const auto pixel = (std::uint64_t(static_cast<std::uint32_t>(y)) << 32) | static_cast<std::uint32_t>(x);
    const std::uint64_t key = mix_bits(mix_bits(seed_ ^ pixel) + dimension.value * 0xd1342543de82ef95ull);
    const std::uint64_t more = mix_bits(key);
    const auto low = [](std::uint64_t bits) { return static_cast<std::uint32_t>(bits); };
    const SobolPair p = sobol_pair(owen_scramble(index, low(key)));
    return {unit_float(owen_scramble(p.x, low(key >> 32))), unit_float(owen_scramble(p.y, low(more)))};
}

}  // namespace occam::render
