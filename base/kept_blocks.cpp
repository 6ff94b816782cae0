#include "base/kept_blocks.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>

#include "base/processors.h"

namespace occam::kept_blocks {
namespace {

// Returns the size of the blocks that hold so many bytes: a multiple of a sixteenth of the largest power of two below, and
// of kLeastStep.
std::size_t size_for(std::size_t bytes) noexcept
{
    constexpr std::size_t kLeastStep = std::size_t(16) << 10;  // a multiple of the pages of all processors but the rarest
    const std::size_t step = std::max(kLeastStep, std::bit_floor(bytes) / 16);
    return bytes > ~step ? bytes : (bytes + step - 1) / step * step;
}

struct IdleBlock {
    std::byte* data;
    std::size_t bytes;
};

// The blocks that nobody has, in the order in which they were given.
class Idle {
public:
    // Returns a block of exactly that size; null if there is none.
    std::byte* take(std::size_t bytes) noexcept
    {
        const std::lock_guard guard(mutex_);
        // The youngest is the most likely one to be in a cache.
        const auto found = std::find_if(blocks_.rbegin(), blocks_.rend(),
                                        [=](const IdleBlock& b) { return b.bytes == bytes; });
        if (found == blocks_.rend()) return nullptr;
        std::byte* const data = found->data;
        blocks_.erase(std::next(found).base());
        bytes_ -= bytes;
        return data;
    }
    void give(IdleBlock block) noexcept
    {
        if (!kKeeps || block.bytes > most_) return unmap(block);
        const std::lock_guard guard(mutex_);
        const auto room = most_ - block.bytes;
        auto end = blocks_.begin();
        for (; bytes_ > room; ++end) {
            unmap(*end);
            bytes_ -= end->bytes;
        }
        blocks_.erase(blocks_.begin(), end);
        try {
            blocks_.push_back(block);
            bytes_ += block.bytes;
        } catch (const std::bad_alloc&) {
            unmap(block);
        }
    }
    std::size_t bytes() noexcept
    {
        const std::lock_guard guard(mutex_);
        return bytes_;
    }

private:
    static void unmap(const IdleBlock& block) noexcept { munmap(block.data, block.bytes); }

    std::mutex mutex_;
    std::vector<IdleBlock> blocks_;
    std::size_t bytes_ = 0;
    const std::size_t most_ = kMostIdleBytes * static_cast<std::size_t>(processor_count());
};

// It is never destroyed, since threads may still give blocks while the process ends.
Idle& idle()
{
    static Idle& blocks = *new Idle;
    return blocks;
}

std::atomic<std::size_t> fresh{0};

}  // namespace

Block take(std::size_t bytes)
{
    const std::size_t size = size_for(bytes);
    if (std::byte* const data = idle().take(size)) return {data, false};
    void* const pages = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    fresh.fetch_add(1, std::memory_order_relaxed);
    return {static_cast<std::byte*>(pages), true};
}

void give(std::byte* block, std::size_t bytes) noexcept { idle().give({block, size_for(bytes)}); }

std::size_t idle_bytes() noexcept { return idle().bytes(); }

std::size_t fresh_count() noexcept { return fresh.load(std::memory_order_relaxed); }

}  // namespace occam::kept_blocks
