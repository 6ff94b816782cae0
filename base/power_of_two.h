// Powers of two from their exponents, without a call: the C library's ldexp looks after cases that do not occur here.
#pragma once

#include <bit>
#include <cstdint>

namespace occam {

/// 2^n, exact; n from -126 to 127.
inline float power_of_two(int n) noexcept { return std::bit_cast<float>(static_cast<std::uint32_t>(n + 127) << 23); }
/// The same in double; n from -1022 to 1023.
inline double power_of_two_double(int n) noexcept
{
    return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

}  // namespace occam
