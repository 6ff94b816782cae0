// Tests of the blocks of memory that are kept from frame to frame.
#include "base/kept_blocks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "base/processors.h"
#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

std::size_t most_idle() { return kept_blocks::kMostIdleBytes * static_cast<std::size_t>(processor_count()); }

TEST(KeptBlocks, HoldAsManyBytesAsAskedAndAreTakenAgain)
{
    for (const std::size_t bytes : {kept_blocks::kLeastBytes, std::size_t(100'001), std::size_t(1'500'000)}) {
        const kept_blocks::Block first = kept_blocks::take(bytes);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first.data) % 4096, 0u);
        std::memset(first.data, 1, bytes);
        kept_blocks::give(first.data, bytes);
        if (!kept_blocks::kKeeps) continue;
        const kept_blocks::Block again = kept_blocks::take(bytes);
        EXPECT_EQ(again.data, first.data) << bytes;
        EXPECT_FALSE(again.is_fresh);
        kept_blocks::give(again.data, bytes);
    }
}

TEST(KeptBlocks, GoBackToTheSystemBeyondALimit)
{
    constexpr std::size_t kBytes = 1 << 20;
    std::vector<std::byte*> blocks;
    for (std::size_t all = 0; all < 2 * most_idle(); all += kBytes) blocks.push_back(kept_blocks::take(kBytes).data);
    for (std::byte* block : blocks) {
        kept_blocks::give(block, kBytes);
        EXPECT_LE(kept_blocks::idle_bytes(), most_idle());
    }
    kept_blocks::give(kept_blocks::take(2 * most_idle()).data, 2 * most_idle());
    EXPECT_LE(kept_blocks::idle_bytes(), most_idle());
}

TEST(KeptBlocks, OfOneFrameAreThoseOfTheNext)
{
    if (!kept_blocks::kKeeps) GTEST_SKIP() << "no block is kept with the address sanitizer";
    Scene scene;
    test::place(scene, scene.add(test::torus()), {0, 0, 0}, 1);
    const Camera camera = Camera::look_at({0, 2, 4}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    Renderer renderer({.threads = 1});
    const auto make = [&] {
        const std::size_t before = kept_blocks::fresh_count();
        renderer.render(scene, camera, {.width = 96, .height = 64, .spp = 4});
        return kept_blocks::fresh_count() - before;
    };
    make();
    for (int frame = 0; frame < 3; ++frame) EXPECT_EQ(make(), 0u);
}

TEST(KeptVector, KeepsItsElementsWhileItGrows)
{
    KeptVector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < 200'000; ++i) numbers.push_back(i);
    for (std::uint32_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], i);
    numbers.assign(100'000, 7);
    EXPECT_EQ(numbers.back(), 7u);
}

}  // namespace
}  // namespace occam
