// How much memory the process has at this moment.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <fstream>

#include "tests/support/campaign.h"

namespace occam::test {

/// Returns the bytes of the process that are in memory; 0 where the system does not say.
inline std::size_t resident_bytes()
{
    std::size_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// Returns whether resident_bytes() tells how much was allocated: the sanitizers have allocators of their own, which keep
/// what is freed.
inline bool can_measure_memory() { return !kIsSanitized && resident_bytes() > 0; }

}  // namespace occam::test
