// Tests of rays that graze dense cages where one level ends and the next begins.
#include <gtest/gtest.h>

#include "lod/topology_cache.h"
#include "tests/support/campaign.h"
#include "tests/support/refined_cages.h"
#include "tests/support/shape_builders.h"
#include "verify/grazing.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

constexpr float kRadius = 1.7322f;

lod::LevelSettings levels_of(float overlap_ulps)
{
    lod::LevelSettings levels;
    levels.pixel = {lod::edge_length(-8), 0};
    levels.shading_rate = 1 / lod::LevelSettings::kLongestEdge;
    if (overlap_ulps > 0) {
        levels.overlap_edges = 0;
        levels.overlap_ulps = overlap_ulps;
        levels.least_coordinate = kRadius;
    }
    return levels;
}

class GrazingRay : public testing::Test {
protected:
    GrazingRay()
    {
        Cage cage = creased_cube(0);
        for (int step = 0; step < 5; ++step) cage = refined(cage, false);
        place(scene_, scene_.add(cage), {0, 0, 0});
        scene_.refit();
        // This ray hits a flat face at 1.1 degrees, 2.3e-6 behind a transition from one pair of levels to the next.
        ray_.origin = {0.98571792337282949, 0.81875034396728574, -0.2024929599120085};
        ray_.direction = {0.019855868071317673f, -0.29924282431602478f, -0.95397037267684937f};
        ray_.footprint = {0, 0.010861475951969624f};
    }

    bool is_met(const lod::LevelSettings& levels)
    {
        const accel::Frame frame(scene_, topologies_, levels);
        accel::Tracer tracer(frame, std::size_t(1) << 28);
        accel::SurfaceHit hit;
        tracer.closest({&ray_, 1}, {&hit, 1});
        return hit.is_hit();
    }
    bool is_explained()
    {
        const lod::LevelSettings narrow = levels_of(4);
        lod::RayLevels<float> table;
        constexpr float kFar = 4 * kRadius;
        EXPECT_TRUE(table.set({ray_.footprint.a, ray_.footprint.b}, 0, kFar, kFar, narrow));
        table.make();
        return GrazingRays(scene_, topologies_, levels_of(0), nullptr, kRadius).explain(ray_, table);
    }

    Scene scene_;
    lod::TopologyCache topologies_;
    accel::Ray ray_;
};

TEST_F(GrazingRay, MeetsTheSurfaceWithTheOverlapOfTheEngineAndIsExplained)
{
    EXPECT_TRUE(is_met(levels_of(0)));
    EXPECT_TRUE(is_explained());
}

TEST_F(GrazingRay, IsNotExplainedFarFromAnyTransition)
{
    ray_.footprint = {0.012f, 0};
    EXPECT_FALSE(is_explained());
    ray_.footprint = {0, 0.0125f};
    EXPECT_FALSE(is_explained());
}

TEST_F(GrazingRay, IsNotExplainedIfItMeetsNothingAtAll)
{
    ray_.origin.x = 3;
    EXPECT_FALSE(is_explained());
}

void expect_no_escape(const Cage& cage)
{
    VerifySettings settings;
    settings.rays = is_long() ? 100'000 : 20'000;
    settings.largest_rate = 8;
    const VerifiedCage found = verify(cage, Mat4d(1), settings);
    ASSERT_GT(found.rays, 0u) << found.not_testable;
    EXPECT_EQ(found.escaped, 0u) << (found.replay.empty() ? "" : found.replay.front());
    EXPECT_LE(found.grazing, 10u);
    EXPECT_EQ(found.not_finite, 0u);
}

// By default one cage is not smoothed, and the two others are.
TEST(LevelsOfDenseCages, LetNoRayOut)
{
    for (const bool is_smooth : {false, true}) {
        Cage cube = creased_cube(0), pyramid = spindle(4);
        for (int step = 0; step < 3; ++step) {
            cube = refined(cube, is_smooth);
            pyramid = refined(pyramid, is_smooth);
        }
        if (is_long() || !is_smooth) expect_no_escape(cube);
        if (is_long() || is_smooth) expect_no_escape(pyramid);
        if (is_long() || is_smooth) expect_no_escape(with_triangles(cube, 1));
    }
}

TEST(LevelsOfCreasedCubes, LetNoRayOut)
{
    EveryNth tested(4);
    for (const float sharpness : {0.25f, 1.5f, 3.75f, 5.25f, 6.0f, 7.5f, 8.25f, 9.75f, 10.0f})
        if (tested.takes()) expect_no_escape(creased_cube(sharpness));
}

}  // namespace
}  // namespace occam::test
