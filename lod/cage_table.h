// Keeps what was last computed for patches, curves or vertices of placed cages: a direct-mapped table.
//
// Memory   its own vector; a newer entry replaces the older one in the same slot.
// Threads  one at a time, as for the dicer that owns it.
#pragma once

#include <cstdint>
#include <vector>

#include "base/hash.h"
#include "lod/posed_cage.h"

namespace occam::lod {

/// kSize   the number of entries, a power of two
template <class Key, class Value, std::size_t kSize>
class CageTable {
public:
    struct Entry {
        const PosedCage* cage = nullptr;  ///< null: the entry is free
        Key key{};
        Value value{};
        bool holds(const PosedCage& of, const Key& k) const noexcept { return cage == &of && key == k; }
    };

    CageTable() : entries_(kSize) {}

    /// Frees all entries; their values keep their memory.
    void forget() noexcept
    {
        for (Entry& e : entries_) e.cage = nullptr;
    }
    /// Returns the entry in which something is kept, if it is kept; it may hold something else. Consecutive indices get
    /// consecutive entries, so that neighbours do not replace each other and are close in memory.
    Entry& entry(const PosedCage& cage, std::uint64_t index) noexcept
    {
        return entries_[static_cast<std::size_t>(mix_bits(reinterpret_cast<std::uintptr_t>(&cage)) + index) & (kSize - 1)];
    }

private:
    std::vector<Entry> entries_;
};

}  // namespace occam::lod
