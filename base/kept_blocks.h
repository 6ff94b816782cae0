// Blocks of memory that the next frame needs again: queues of rays and the chunks of trees. They are kept while nobody has
// them, since the system takes longer to make pages than a small frame takes to fill them.
//
// Memory   From the system and not from the heap, which would grow whenever anything small that stays took the place of
//          such a block. At most kMostIdleBytes for each processor are kept; beyond that, those go back to the system that
//          have been idle longest. With the address sanitizer none is kept, and vectors are on the heap.
// Threads  Any thread may take and give blocks.
// Source   The sizes are those of allocators with size classes: sixteen for each power of two from 256 KiB on, so that at
//          most a sixteenth of a block is unused, and multiples of 16 KiB below.
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <vector>

namespace occam {

namespace kept_blocks {

inline constexpr std::size_t kLeastBytes = std::size_t(64) << 10;    ///< of a block that is worth keeping
inline constexpr std::size_t kMostIdleBytes = std::size_t(8) << 20;  ///< for each processor
#if defined(__SANITIZE_ADDRESS__)                                    // g++
inline constexpr bool kKeeps = false;
#elif defined(__has_feature)
inline constexpr bool kKeeps = !__has_feature(address_sanitizer);
#else
inline constexpr bool kKeeps = true;
#endif

struct Block {
    std::byte* data;  ///< aligned to a page
    bool is_fresh;    ///< it comes from the system: its bytes are 0, and its pages are not made yet
};

/// Returns a block of at least `bytes` bytes, which give() takes back. Throws std::bad_alloc.
Block take(std::size_t bytes);
/// Takes a block back that take(bytes) has returned.
void give(std::byte* block, std::size_t bytes) noexcept;
/// Returns the bytes of the blocks that nobody has.
std::size_t idle_bytes() noexcept;
/// Returns how many blocks have come from the system so far.
std::size_t fresh_count() noexcept;

}  // namespace kept_blocks

/// Allocates the elements of a vector in blocks that are kept, if they are long enough.
template <class T>
struct KeptAllocator {
    using value_type = T;

    KeptAllocator() = default;
    template <class U>
    KeptAllocator(const KeptAllocator<U>&) noexcept
    {
    }

    T* allocate(std::size_t count)
    {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        const std::size_t bytes = count * sizeof(T);
        if (is_kept(bytes)) return reinterpret_cast<T*>(kept_blocks::take(bytes).data);
        return static_cast<T*>(::operator new(bytes, std::align_val_t(alignof(T))));
    }
    void deallocate(T* p, std::size_t count) noexcept
    {
        const std::size_t bytes = count * sizeof(T);
        if (is_kept(bytes)) kept_blocks::give(reinterpret_cast<std::byte*>(p), bytes);
        else ::operator delete(p, std::align_val_t(alignof(T)));
    }
    friend bool operator==(const KeptAllocator&, const KeptAllocator&) noexcept { return true; }

private:
    static bool is_kept(std::size_t bytes) noexcept { return kept_blocks::kKeeps && bytes >= kept_blocks::kLeastBytes; }
};

/// A vector whose memory is kept for the next frame.
template <class T>
using KeptVector = std::vector<T, KeptAllocator<T>>;

}  // namespace occam
