// Tests that memory which was freed goes back to the system when the allocator keeps too much of it.
#include "base/freed_memory.h"
#include "tests/support/resident_memory.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace occam {
namespace {

// A thread takes 128 MiB in small blocks and frees all but the last. That one keeps the allocator from returning the others.
TEST(FreedMemory, GoesBackToTheSystemIfThereIsTooMuch)
{
    if (!test::can_measure_memory()) GTEST_SKIP() << "sanitizers have allocators of their own, or there is no /proc";
    constexpr std::size_t kBlock = 16 << 10, kBlocks = 8192;
    std::unique_ptr<std::byte[]> last;
    std::thread([&last] {
        std::vector<std::unique_ptr<std::byte[]>> blocks;
        for (std::size_t i = 0; i < kBlocks; ++i) blocks.push_back(std::make_unique<std::byte[]>(kBlock));
        last = std::move(blocks.back());
    }).join();
    const std::size_t freed = test::resident_bytes();
    return_freed_memory(std::size_t(1) << 40);
    EXPECT_GE(test::resident_bytes() + (std::size_t(8) << 20), freed) << "less is kept than may be";
    return_freed_memory(std::size_t(64) << 20);
    EXPECT_LE(test::resident_bytes() + (std::size_t(100) << 20), freed);
}

}  // namespace
}  // namespace occam
