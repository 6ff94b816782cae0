#include "tests/faults/failing_allocations.h"

#include <dlfcn.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>

namespace occam::test {
namespace {

constinit std::atomic<bool> is_armed{false};
constinit std::atomic<std::uint64_t> first_failing{0}, failing_count{0}, asked_for{0}, failures{0};
constinit std::atomic<std::int64_t> alive{0};

/// Returns whether the process may end if the code at an address gets no memory: tinygltf destroys JSON documents, which
/// takes memory, and OpenImageIO takes some in functions that may not throw. What they take by other libraries fails all the
/// same.
bool may_end_the_process(const void* code) noexcept
{
    Dl_info place{};
    if (dladdr(code, &place) == 0 || !place.dli_fname) return false;
    return std::strstr(place.dli_fname, "tinygltf") || std::strstr(place.dli_fname, "OpenImageIO");
}

bool has_to_fail(const void* caller) noexcept
{
    if (!is_armed.load(std::memory_order_relaxed)) return false;
    const std::uint64_t number = asked_for.fetch_add(1, std::memory_order_relaxed), first = first_failing;
    if (number < first || number - first >= failing_count) return false;
    if (may_end_the_process(caller)) {
        asked_for.fetch_sub(1, std::memory_order_relaxed);  // the next one fails in its place
        return false;
    }
    failures.fetch_add(1, std::memory_order_relaxed);
    return true;
}

/// Returns null if the allocation is one of those that fail, or if there is no memory.
void* allocate(std::size_t bytes, std::size_t alignment, const void* caller) noexcept
{
    if (has_to_fail(caller)) return nullptr;
    const std::size_t size = bytes > 0 ? (bytes + alignment - 1) / alignment * alignment : alignment;
    void* const block = alignment <= alignof(std::max_align_t) ? std::malloc(size) : std::aligned_alloc(alignment, size);
    if (block) alive.fetch_add(1, std::memory_order_relaxed);
    return block;
}

void* allocate_or_throw(std::size_t bytes, std::size_t alignment, const void* caller)
{
    if (void* const block = allocate(bytes, alignment, caller)) return block;
    throw std::bad_alloc();
}

void release(void* block) noexcept
{
    if (!block) return;
    alive.fetch_sub(1, std::memory_order_relaxed);
    std::free(block);
}

constexpr std::size_t kUsual = alignof(std::max_align_t);

}  // namespace

std::int64_t blocks_alive() noexcept { return alive; }

FailingAllocations::FailingAllocations(std::uint64_t first, std::uint64_t count) noexcept
{
    first_failing = first;
    failing_count = count;
    asked_for = failures = 0;
    is_armed = true;
}
FailingAllocations::~FailingAllocations() { is_armed = false; }
std::uint64_t FailingAllocations::made() const noexcept { return asked_for; }
std::uint64_t FailingAllocations::failed() const noexcept { return failures; }

}  // namespace occam::test

using namespace occam::test;

// The forms for arrays call these. Those with a size do, too.
void* operator new(std::size_t bytes) { return allocate_or_throw(bytes, kUsual, __builtin_return_address(0)); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept
{
    return allocate(bytes, kUsual, __builtin_return_address(0));
}
void* operator new(std::size_t bytes, std::align_val_t alignment)
{
    return allocate_or_throw(bytes, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept
{
    return allocate(bytes, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void operator delete(void* block) noexcept { release(block); }
void operator delete(void* block, std::size_t) noexcept { release(block); }
void operator delete(void* block, std::align_val_t) noexcept { release(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { release(block); }
