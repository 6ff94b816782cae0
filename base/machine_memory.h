// The memory of the machine.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstddef>

namespace occam {

/// Returns the bytes of memory that the machine has; 0 if the system does not say.
inline std::size_t machine_memory_bytes() noexcept
{
    const auto pages = static_cast<std::size_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
    return pages * static_cast<std::size_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
}

}  // namespace occam
