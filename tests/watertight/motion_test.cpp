// No ray leaves a closed cage while it moves, whatever the ray's time and footprint (docs/watertightness.md, rules of
// motion).
#include <gtest/gtest.h>

#include "tests/support/displaced_cages.h"
#include "tests/support/escapes.h"
#include "tests/support/motions.h"
#include "tests/support/shape_builders.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

/// At the origin segments overlap by 4 ulps only, so that nothing is hidden; far away as the engine has them.
void expect_no_escape(const Cage& cage, const Motion& motion, int largest_rate)
{
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    for (const Mat4d& place : {Mat4d(1), far}) {
        Scene scene;
        add_moving(scene, cage, motion, place);
        VerifySettings settings;
        settings.rays = is_long() ? blended_rays_per_place() : 2'048;
        settings.largest_rate = largest_rate;
        settings.overlap_ulps = place == Mat4d(1) ? 4.0f : 0.0f;
        std::uint64_t tested = 0;
        for (const VerifiedCage& found : verify(scene, settings)) {
            tested += found.rays;
            std::string replay;
            for (const std::string& line : found.replay) replay += line + '\n';
            EXPECT_EQ(found.escaped, 0u) << motion.name << ", of " << found.rays << " at " << place[3].x << '\n' << replay;
            EXPECT_EQ(found.not_finite, 0u) << motion.name;
            EXPECT_LE(found.outside, found.rays / 1000) << motion.name;  // or it tests too little
        }
        EXPECT_GT(tested, 0u) << motion.name;
    }
}

class MovingCages : public testing::TestWithParam<Motion> {};
TEST_P(MovingCages, LetNoRayOut)
{
    expect_no_escape(torus(), GetParam(), is_long() ? 16 : 4);
    expect_no_escape(prism(7), GetParam(), is_long() ? 16 : 4);
    if (is_long()) expect_no_escape(creased_cube(2.5f), GetParam(), 32);
}
INSTANTIATE_TEST_SUITE_P(Motions, MovingCages, testing::ValuesIn(motions()),
                         [](const auto& test) { return test.param.name; });

TEST(MovingSpindle, OfValence9LetsNoRayOut)
{
    Cage cage = spindle(9);
    cage.creases = {{0, 2, 10}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    for (const Motion& motion : motions())
        if (is_long() || motion.segments == 4) expect_no_escape(cage, motion, is_long() ? 8 : 4);
}

}  // namespace
}  // namespace occam::test
