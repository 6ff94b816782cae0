// Tests which frames count as such that would not end, and that these are refused.
#include <gtest/gtest.h>

#include "accel/build_effort.h"

namespace occam::test {
namespace {

using accel::BuildEffort;

TEST(BuildEffort, IsHopelessWhereFewRaysUseUpTheBudgetAgainAndAgain)
{
    BuildEffort effort;
    effort.add_rays(1'000'000);  // before the budget was used up for the first time
    for (int i = 0; i < 2 * BuildEffort::kLeastFlushes; ++i) {
        EXPECT_EQ(effort.is_hopeless(), i >= BuildEffort::kLeastFlushes) << i;
        effort.add_flush(BuildEffort::kLeastBytes / BuildEffort::kLeastFlushes);
        effort.add_rays(10);
    }
    EXPECT_EQ(effort.rays(), 10u * 2 * BuildEffort::kLeastFlushes);
}

TEST(BuildEffort, IsNotHopelessWhileRaysEndOrLittleIsBuilt)
{
    BuildEffort many_rays, little_memory;
    for (int i = 0; i < 1000; ++i) {
        constexpr std::size_t kBudget = std::size_t(3) << 30;
        many_rays.add_flush(kBudget);
        many_rays.add_rays(kBudget / BuildEffort::kMostBytesARay);
        EXPECT_FALSE(many_rays.is_hopeless());
        little_memory.add_flush(BuildEffort::kLeastBytes / 1000 - 1);
        EXPECT_FALSE(little_memory.is_hopeless());
    }
}

}  // namespace
}  // namespace occam::test
