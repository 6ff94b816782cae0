// Tests that memory which was freed goes back to the system when the allocator keeps too much of it.
#include "base/freed_memory.h"
#include "tests/support/campaign.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <thread>
#include <vector>

namespace occam {
namespace {

std::size_t resident_bytes()
{
    std::size_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// A thread takes 128 MiB in small blocks and frees all but the last. That one keeps the allocator from returning the others.
TEST(FreedMemory, GoesBackToTheSystemIfThereIsTooMuch)
{
    if (test::kIsSanitized || resident_bytes() == 0) GTEST_SKIP() << "the sanitizers have allocators of their own";
    constexpr std::size_t kBlock = 16 << 10, kBlocks = 8192;
    std::unique_ptr<std::byte[]> last;
    std::thread([&last] {
        std::vector<std::unique_ptr<std::byte[]>> blocks;
        for (std::size_t i = 0; i < kBlocks; ++i) blocks.push_back(std::make_unique<std::byte[]>(kBlock));
        last = std::move(blocks.back());
    }).join();
    const std::size_t freed = resident_bytes();
    return_freed_memory(std::size_t(1) << 40);
    EXPECT_GE(resident_bytes() + (std::size_t(8) << 20), freed) << "less is kept than may be";
    return_freed_memory(std::size_t(64) << 20);
    EXPECT_LE(resident_bytes() + (std::size_t(100) << 20), freed);
}

}  // namespace
}  // namespace occam
