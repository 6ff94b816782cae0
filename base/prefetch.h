// Asks the caches to load what will be read soon. This is a hint, and any address is allowed.
#pragma once

#include <cstddef>

namespace occam {

inline void prefetch(const void* p) noexcept { __builtin_prefetch(p); }

/// Asks for bytes that will be written.
inline void prefetch_to_write(const void* p, std::size_t bytes) noexcept
{
    constexpr std::size_t kLine = 64;
    const char* first = static_cast<const char*>(p);
    for (std::size_t at = 0; at < bytes; at += kLine) __builtin_prefetch(first + at, 1);
    __builtin_prefetch(first + bytes - 1, 1);
}

}  // namespace occam
