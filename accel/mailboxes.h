// Which igrids the packet that is under way has met: a grid that lies in several cells is met once.
//
// Threads  one worker's own.
#pragma once

#include <vector>

#include "accel/igrid.h"
#include "base/hash.h"

namespace occam::accel {

/// A worker with a tree of its own writes into the igrids. One that shares its tree has a table by the igrid's address: of
/// two igrids with one place in it either may be met twice, which does no harm.
class Mailboxes {
public:
    explicit Mailboxes(bool is_shared) : slots_(is_shared ? kSlots : 0) {}

    GridVisit& of(IGrid& grid) noexcept
    {
        if (slots_.empty()) return grid.visit;
        Slot& slot = slots_[mix_bits(reinterpret_cast<std::uintptr_t>(&grid)) % kSlots];
        if (slot.grid != &grid) slot = {&grid, {}};
        return slot.visit;
    }

private:
    struct Slot {
        const IGrid* grid = nullptr;
        GridVisit visit;
    };
    static constexpr std::size_t kSlots = 1024;
    std::vector<Slot> slots_;
};

}  // namespace occam::accel
