// Half floats (IEEE 754 binary16) as stored in memory. The conversions use integers and single operations on
// floats, so they give the same bits everywhere.
#pragma once

#include <bit>
#include <cstdint>

namespace occam {

/// Converts exactly.
inline float float_from_half(std::uint16_t h) noexcept
{
    // A multiplication by 2^112 rebases the exponent, which also makes subnormals normal.
    const float magnitude = std::bit_cast<float>(std::uint32_t(h & 0x7fffu) << 13) * std::bit_cast<float>(0x77800000u);
    std::uint32_t bits = std::bit_cast<std::uint32_t>(magnitude);
    if ((h & 0x7c00u) == 0x7c00u) bits |= 0x7f800000u;
    return std::bit_cast<float>(bits | std::uint32_t(h & 0x8000u) << 16);
}

/// Rounds to nearest, ties to even. A value that is too large becomes the largest finite half, 65504, and NaN becomes 0, so
/// that texels are always numbers.
inline std::uint16_t finite_half_from_float(float f) noexcept
{
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(f), magnitude = bits & 0x7fffffffu;
    const std::uint32_t sign = bits >> 16 & 0x8000u;
    if (magnitude > 0x7f800000u) return 0;
    if (magnitude >= 0x477ff000u) return static_cast<std::uint16_t>(sign | 0x7bffu);
    if (magnitude < 0x38800000u) {
        // Below 2^-14: adding 1/2 leaves the half's 10 bits, rounded, at the end of the float's mantissa.
        const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
        return static_cast<std::uint16_t>(sign | (std::bit_cast<std::uint32_t>(shifted) - 0x3f000000u));
    }
    const std::uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
    return static_cast<std::uint16_t>(sign | (rounded - 0x38000000u) >> 13);
}

}  // namespace occam
