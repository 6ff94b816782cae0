// Records which igrids the current packet was tested against, so that an igrid that lies in several cells is tested once.
//
// Threads  Each worker has its own.
#pragma once

#include <vector>

#include "accel/igrid.h"
#include "base/hash.h"

namespace occam::accel {

/// Keeps the records of a worker that owns its tree in the igrids themselves, and those of a worker that shares its tree in
/// a table hashed by the igrid's address. Two igrids that share a slot may be tested more than once, which does no harm.
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
