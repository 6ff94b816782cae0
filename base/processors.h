// How many processors this process may use.
#pragma once

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <thread>

#include "base/container_limits.h"

namespace occam {

/// Returns the number of processors on which the system lets this process run (taskset, a batch system, a container's set of
/// processors), or else that of the machine; at least 1.
inline int processors_of_set()
{
    struct Free {
        void operator()(cpu_set_t* set) const noexcept { CPU_FREE(set); }
    };
    // The system refuses a set with fewer bits than it has processors.
    for (std::size_t bits = CPU_SETSIZE; bits <= std::size_t(1) << 20; bits *= 4) {
        const std::unique_ptr<cpu_set_t, Free> set(CPU_ALLOC(bits));
        if (!set) break;
        if (sched_getaffinity(0, CPU_ALLOC_SIZE(bits), set.get()) != 0) continue;
        return std::max(1, CPU_COUNT_S(CPU_ALLOC_SIZE(bits), set.get()));
    }
    return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// Returns the number of threads that keep busy what the process may use: processors_of_set(), or as many as its container's
/// share of time is worth if they are fewer, rounded up.
inline int processor_count()
{
    const int count = processors_of_set();
    const double share = own_container_limits().processors;
    return share > 0 && share < double(count) ? std::max(1, static_cast<int>(std::ceil(share))) : count;
}

}  // namespace occam
