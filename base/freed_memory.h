// Returns memory to the system that was freed but that the allocator keeps.
#pragma once

#include <malloc.h>

#include <cstddef>

namespace occam {

/// Returns freed memory to the system if the allocator keeps more than `most_kept` bytes of it.
///
/// The GNU C library keeps what a thread frees in the arena of that thread. The threads of a later frame may use other
/// arenas, so without this a process that renders many frames may hold the peak of a frame many times.
/// Threads: may be called at any time.
inline void return_freed_memory([[maybe_unused]] std::size_t most_kept) noexcept
{
#ifdef __GLIBC__
    if (mallinfo2().fordblks > most_kept) malloc_trim(0);
#endif
}

}  // namespace occam
