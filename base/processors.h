// How many processors this process may use.
#pragma once

#include <sched.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <thread>

namespace occam {

/// Returns the number of processors on which the system lets this process run (taskset, a batch system, a container's set of
/// processors), or else that of the machine; at least 1.
inline int processor_count()
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

}  // namespace occam
