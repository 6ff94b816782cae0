// Hashes with 64 bits: FNV-1a over bytes in order, for checksums and keys, and faster ones for whole files and for tables
// whose keys are lists of words. None of them withstands an adversary.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

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

/// Hashes bytes eight at a time, on top of what is hashed already. The last ones are filled up with zeros, so the number of
/// bytes has to be hashed, too. Files of gigabytes take a fraction of a second.
inline std::uint64_t hash_in_eights(const void* data, std::size_t bytes, std::uint64_t h) noexcept
{
    const unsigned char* p = static_cast<const unsigned char*>(data);
    const auto add = [&](std::size_t from, std::size_t count) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, p + from, count);
        h = (std::rotl(h, 26) ^ eight) * 0x9e3779b97f4a7c15ull;
    };
    std::size_t i = 0;
    for (; i + 8 <= bytes; i += 8) add(i, 8);
    if (i < bytes) add(i, bytes - i);
    return h;
}

/// Hashes lists of words for tables in memory.
struct WordsHash {
    std::size_t operator()(const std::vector<std::uint32_t>& words) const noexcept
    {
        return static_cast<std::size_t>(
            mix_bits(hash_in_eights(words.data(), words.size() * sizeof words[0], words.size())));
    }
};

}  // namespace occam
