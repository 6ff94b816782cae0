// Asking the caches for what will be read soon. A hint: any address will do.
#pragma once

namespace occam {

inline void prefetch(const void* p) noexcept { __builtin_prefetch(p); }

}  // namespace occam
