#include "io/import/key_numbers.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace occam {
namespace {

TEST(KeyNumbers, CountKeysInTheOrderInWhichTheyFirstAppear)
{
    std::mt19937 random(4);
    for (const std::uint32_t different : {1u, 2u, 100u, 5000u}) {
        import::KeyNumbers<3> numbers;
        std::map<import::BitsKey<3>, std::uint32_t> expected;
        EXPECT_EQ(numbers.size(), 0u);
        for (int i = 0; i < 20'000; ++i) {
            // Keys that differ in one word alone, as coordinates of grids do.
            import::BitsKey<3> key{1, 2, 3};
            const std::uint32_t word = random() % 3;
            key[word] = (random() % different) << (random() % 2 * 20);
            const auto [entry, is_new] = expected.try_emplace(key, static_cast<std::uint32_t>(expected.size()));
            ASSERT_EQ(numbers.number_of(key), entry->second) << different << ' ' << i;
            ASSERT_EQ(numbers.size(), expected.size());
        }
    }
}

}  // namespace
}  // namespace occam
