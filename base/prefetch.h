// Asks the caches to load what will be read soon. This is a hint, and any address is allowed.
#pragma once

namespace occam {

inline void prefetch(const void* p) noexcept { __builtin_prefetch(p); }

}  // namespace occam
