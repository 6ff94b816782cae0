// Keys of tables that hold the bits of several numbers.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "base/hash.h"

namespace occam::import {

template <std::size_t N>
using BitsKey = std::array<std::uint32_t, N>;

struct BitsHash {
    template <std::size_t N>
    std::size_t operator()(const BitsKey<N>& key) const noexcept
    {
        std::uint64_t mixed = 0;
        for (std::size_t i = 0; i < N; i += 2)
            mixed = mix_bits(mixed ^ key[i] ^ std::uint64_t(i + 1 < N ? key[i + 1] : 0) << 32);
        return static_cast<std::size_t>(mixed);
    }
};

/// Returns the bits of a coordinate; -0 has those of 0, since both are the same position.
inline std::uint32_t bits_of(float x) { return std::bit_cast<std::uint32_t>(x + 0.0f); }

}  // namespace occam::import
