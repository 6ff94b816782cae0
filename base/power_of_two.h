// Computes powers of two from their exponents inline. The C library's ldexp also handles cases that do not occur here.
#pragma once

#include <bit>
#include <cstdint>

namespace occam {

/// Returns 2^n exactly; n is from -126 to 127.
inline float power_of_two(int n) noexcept { return std::bit_cast<float>(static_cast<std::uint32_t>(n + 127) << 23); }
/// Returns 2^n exactly in double; n is from -1022 to 1023.
inline double power_of_two_double(int n) noexcept
{
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

}  // namespace occam
