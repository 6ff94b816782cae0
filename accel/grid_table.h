// Maps a subject, a pair of levels and a tile to the igrid that was built for them. All leaves point at one
// igrid per key (see docs/architecture.md).
//
// Memory   The arena of the tree; when the table grows, the smaller one stays behind.
// Threads  One thread at a time: the owner of the tree, or the worker that holds the lock of a shared tree.
#pragma once

#include "accel/igrid.h"
#include "base/arena.h"
#include "base/hash.h"

namespace occam::accel {

struct GridKey {
    const void* subject = nullptr;  ///< a PatchInfo or a ClusterInfo
    int pair = 0;
    std::uint32_t i = 0, j = 0;  ///< first quad of the tile
    friend bool operator==(const GridKey&, const GridKey&) = default;
};

class GridTable {
public:
    explicit GridTable(Arena& arena) : arena_(arena) { clear(); }

    /// Forgets its contents and its memory. It is called after the arena was reset.
    void clear() noexcept
    {
        slots_ = {};
        used_ = 0;
    }
    /// Returns the slot of a key's igrid, which is null when the key is new. The reference is valid until the next
    /// call.
    IGrid*& operator[](const GridKey& key)
    {
        if (2 * (used_ + 1) > slots_.size()) grow();
        Slot& slot = find(slots_, key);
        if (!slot.key.subject) {
            slot = {key, nullptr};
            ++used_;
        }
        return slot.grid;
    }

private:
    struct Slot {
        GridKey key;
        IGrid* grid = nullptr;
    };

    static Slot& find(std::span<Slot> slots, const GridKey& key) noexcept
    {
        const std::uint64_t hash = mix_bits(
            reinterpret_cast<std::uintptr_t>(key.subject) ^
            mix_bits(std::uint64_t(key.i) << 32 ^ std::uint64_t(key.j) << 8 ^ std::uint64_t(key.pair + 128)));
        for (std::size_t at = hash;; ++at) {
            Slot& slot = slots[at & (slots.size() - 1)];
            if (!slot.key.subject || slot.key == key) return slot;
        }
    }
    void grow()
    {
        const std::span<Slot> larger = arena_.make_array<Slot>(std::max<std::size_t>(64, slots_.size() * 2));
        std::fill(larger.begin(), larger.end(), Slot());
        for (const Slot& slot : slots_)
            if (slot.key.subject) find(larger, slot.key) = slot;
        slots_ = larger;
    }

    Arena& arena_;
    std::span<Slot> slots_;
    std::size_t used_ = 0;
};

}  // namespace occam::accel
