// Tests which frames count as such that would not end, and that these are refused.
#include <gtest/gtest.h>

#include <string>

#include "accel/build_effort.h"
#include "accel/frame.h"
#include "accel/frame_state.h"
#include "accel/lazy_tree.h"
#include "base/error.h"
#include "tests/support/shape_builders.h"

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

// A query that lives long was refused a ray now and then, and answered the same ray when it was asked again.
TEST(BuildEffort, RefusesFramesAndNoQueries)
{
    Scene scene;
    place(scene, scene.add(prism(5)), {0, 0, 0});
    scene.refit();
    lod::TopologyCache topologies;
    for (const bool is_frame : {true, false}) {
        const accel::Frame frame(scene, topologies, {.pixel = {0.01f, 0}}, {.refuses_endless = is_frame});
        accel::LazyTree tree(frame.state(), std::size_t(1) << 24, {}, false);
        for (int i = 0; i < BuildEffort::kLeastFlushes; ++i) tree.effort.add_flush(BuildEffort::kLeastBytes);
        try {
            tree.flush();
            EXPECT_FALSE(is_frame);
        } catch (const Error& error) {
            EXPECT_TRUE(is_frame);
            EXPECT_EQ(std::string(error.what()).find("--"), std::string::npos)
                << "an application has no options: " << error.what();
        }
    }
}

}  // namespace
}  // namespace occam::test
