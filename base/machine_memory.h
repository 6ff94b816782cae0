// The memory of the machine, as far as this process may use it.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstddef>

#include "base/container_limits.h"

namespace occam {

/// Returns the bytes of memory that the machine has, or that the process's container lets it use if they are fewer; 0 if the
/// system does not say.
inline std::size_t machine_memory_bytes() noexcept
{
    const auto pages = static_cast<std::size_t>(std::max(0L, sysconf(_SC_PHYS_PAGES)));
    const std::size_t machine = pages * static_cast<std::size_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
    const std::size_t container = own_container_limits().memory_bytes;
    return container > 0 && (machine == 0 || container < machine) ? container : machine;
}

}  // namespace occam
