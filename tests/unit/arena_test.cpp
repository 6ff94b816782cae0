// Tests that an arena holds little more memory than it counts.
#include "base/arena.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/campaign.h"

namespace occam {
namespace {

// Returns how much memory the process has of the system, whether it was touched or not, but for the blocks that are kept for
// the next arena.
std::size_t allocated_bytes()
{
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) - kept_blocks::idle_bytes();
}

TEST(Arena, HoldsLittleMoreThanItCountsAfterAReset)
{
    constexpr std::size_t kRoom = 16 << 20;
    const std::size_t before = allocated_bytes();
    Arena arena;
    for (int round = 0; round < 4; ++round) {
        // A block that is larger than a chunk comes first in one round, and between others in the next.
        while (arena.bytes() < kRoom) {
            if (arena.bytes() == 0 || round % 2 == 1) arena.make_array<std::byte>(Arena::kChunkBytes + 1024);
            for (int i = 0; i < 64; ++i) arena.make_array<std::byte>(4096);
        }
        // The sizes of kept blocks of at least a chunk are rounded up by a sixteenth at most.
        EXPECT_LE(allocated_bytes() - before, arena.bytes() / 16 * 17 + 2 * Arena::kChunkBytes) << round;
        arena.reset();
    }
    EXPECT_LE(allocated_bytes() - before, kRoom + 2 * Arena::kChunkBytes) << "blocks of their own are not kept";
    arena.reset(1 << 20);
    EXPECT_LE(allocated_bytes() - before, std::size_t(1 << 20) + Arena::kChunkBytes);
}

// Three of five parts of a chunk leave the rest of it unused.
TEST(Arena, HoldsLittleMoreThanItCountsWhateverTheSizeOfAllocations)
{
    if (test::kIsSanitized) GTEST_SKIP() << "sanitizers keep memory that was released to the heap";
    constexpr std::size_t kRoom = 16 << 20;
    for (const std::size_t part : {std::size_t(5), std::size_t(20), std::size_t(60)}) {
        const std::size_t before = allocated_bytes();
        Arena arena;
        for (int round = 0; round < 3; ++round) {
            while (arena.bytes() < kRoom) arena.make_array<std::byte>(3 * Arena::kChunkBytes / part);
            EXPECT_LE(allocated_bytes() - before, arena.bytes() + arena.bytes() / 3 + Arena::kChunkBytes) << part;
            arena.reset();
        }
    }
}

// If something small that stays takes the place of a block that was released, the next such block finds no room there: the
// heap grew by a chunk with each tree that was dropped, and by 17 MB where derived points took as much.
TEST(Arena, ChunksAndLargerBlocksAreNotOfTheHeap)
{
    const auto of_the_heap = [] {
        const struct mallinfo2 info = mallinfo2();
        return info.uordblks + info.hblkhd;
    };
    const std::size_t before = of_the_heap();
    for (const std::size_t bytes : {std::size_t(4096), Arena::kChunkBytes, std::size_t(30) << 20}) {
        Arena arena;
        for (int round = 0; round < 4; ++round) {
            const std::span<std::byte> block = arena.make_array<std::byte>(bytes);
            block.front() = block.back() = std::byte(round);
            EXPECT_LT(of_the_heap(), before + Arena::kChunkBytes / 2) << bytes;
            arena.reset();
        }
    }
}

}  // namespace
}  // namespace occam
