// The FNV-1a hash with 64 bits, over bytes in order. It is meant for checksums and keys and does not withstand an adversary.
#pragma once

#include <cstddef>
#include <cstdint>

namespace occam {

inline constexpr std::uint64_t kFnvStart = 0xcbf29ce484222325ull;

inline std::uint64_t fnv1a(const void* data, std::size_t bytes, std::uint64_t h = kFnvStart) noexcept
{
    const unsigned char* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) h = (h ^ p[i]) * 0x100000001b3ull;
    return h;
}

/// Spreads all bits of x over all bits of the result (a bijection: the finaliser of splitmix64, Steele et al. 2014).
inline std::uint64_t mix_bits(std::uint64_t x) noexcept
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

}  // namespace occam
