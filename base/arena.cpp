#include "base/arena.h"

#include <sys/mman.h>
#include <unistd.h>

namespace occam {

std::byte* Arena::map(std::size_t bytes)
{
    void* const pages = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    return static_cast<std::byte*>(pages);
}

void Arena::unmap(std::byte* pages, std::size_t bytes) noexcept { munmap(pages, bytes); }

void Arena::populate([[maybe_unused]] std::byte* from, [[maybe_unused]] std::size_t bytes) noexcept
{
#ifdef MADV_POPULATE_WRITE  // since Linux 5.14
    static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto at = reinterpret_cast<std::uintptr_t>(from);
    const std::uintptr_t first = (at + page - 1) / page * page, end = (at + bytes) / page * page;
    if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_POPULATE_WRITE);
#endif
}

}  // namespace occam
