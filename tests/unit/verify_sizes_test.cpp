// Tests that `occam verify` sees a cage that grows while the shutter is open as rays see it: at each of its sizes, and where
// it is not left out.
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/shape_builders.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

/// Returns a scene in which a cube is `small` until the last of eight segments, in which it grows to 1.
Scene growing_cube(double small)
{
    Scene scene;
    const CageId cube = scene.add(creased_cube(1));
    const NodeId node = scene.add_node(scene.root(), {.name = "grows", .cages = {cube}});
    scene.record_shutter(8, [&](double tau) {
        Trs place;
        place.scale = Vec3d(tau < 1 ? small : 1.0);
        place.translation = {3, 0, 0};
        scene.set_transform(node, place);
    });
    return scene;
}

TEST(VerifySizes, NoRayLeavesACageThatGrowsMuch)
{
    for (const double small : {0.02, 1e-3, 1e-6}) {
        Scene scene = growing_cube(small);
        const std::vector<VerifiedCage> reports = verify(scene, {.rays = 20'000, .largest_rate = 8});
        ASSERT_EQ(reports.size(), 1u);
        EXPECT_EQ(reports[0].not_testable, "") << small;
        EXPECT_GE(reports[0].rays, 20'000u) << small;
        EXPECT_GT(reports[0].starts, 10u) << small;
        EXPECT_TRUE(reports[0].holds()) << small << ": " << reports[0].escaped << " of " << reports[0].rays << " escaped, "
                                        << reports[0].front_side << " hit a front side";
    }
}

// A cage as an application holds it may break the rules of sanitize().
TEST(VerifySizes, ACageThatIsNotSanitizedIsTestedWithoutWhatIsNoFace)
{
    Cage cube = creased_cube(1);
    cube.holes = {77};
    cube.materials.resize(3);
    EXPECT_TRUE(verify(cube, Mat4d(1), {.rays = 2'000, .largest_rate = 4}).holds());
    EXPECT_TRUE(verify(cube, Mat4d(1), {.rays = 2'000, .largest_rate = 1}).holds());
    for (Vec3f& p : cube.positions) p.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NE(verify(cube, Mat4d(1), {.rays = 2'000}).not_testable, "");
}

}  // namespace
}  // namespace occam::test
