// Tests of what motion makes coarser (lod/cage_motion.h, level_of_motion()).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lod/cage_motion.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr Vec3d kEye{0, 0, 40};

lod::LevelSettings seen_from_afar(int strata)
{
    lod::LevelSettings levels;
    levels.eye = kEye;
    levels.pixel = {0, 0.01f};  // a pixel is 0.4 wide where the cage is
    levels.strata = strata;
    return levels;
}

// Calls what(motion) for a torus that moves so.
template <class What>
auto of_torus(const Motion& motion, What&& what)
{
    Scene scene;
    const NodeId id = add_moving(scene, torus(), motion);
    scene.refit();
    const Node& node = scene.node(id);
    const std::vector<Mat4d> moving = scene.world_from_node_keys(id);
    const Mat4d placed = scene.world_from_node(id);
    const std::span<const Mat4d> matrices = moving.empty() ? std::span(&placed, 1) : std::span(moving);
    const CageSlot& slot = scene.cage(node.cages.front());
    return what(lod::CageMotion(slot, node, scene.find(node.skin), matrices, scene.shutter_segments()));
}

Motion sliding(Vec3d by, bool is_written)
{
    Motion motion{"sliding", 1, {}, {}, {}, {}};
    if (is_written) motion.vertex = [by](Vec3f p, double tau) { return p + Vec3f(by * tau); };
    else motion.matrix = [by](double tau) { return moved_by(by * tau); };
    return motion;
}

// Boxes of nodes are grown by this bound, so that they hold cages below that follow fewer segments.
TEST(MotionTolerance, OfABoxIsNotLargerThanTheBoundOfABoxAroundIt)
{
    Random random(17);
    const auto point = [&] {
        const double x = random(), y = random();
        return Vec3d(x, y, random());
    };
    double least = 1, most = 0;
    for (int i = 0; i < 2000; ++i) {
        lod::LevelSettings levels;
        levels.eye = point() * 4.0 - 1.5;
        levels.pixel = {i % 3 ? 0 : 0.02f, i % 3 ? 0.01f : 0};
        if (i % 3 == 2) levels.motion_edges = 0;  // only rounding is left
        Box3d around, inside;
        for (int corner = 0; corner < 2; ++corner) around.add(point());
        for (int corner = 0; corner < 2; ++corner) inside.add(glm::mix(around.lo, around.hi, point()));
        const double bound = lod::largest_motion_tolerance(levels, around);
        const double share = lod::motion_tolerance(levels, inside) / bound;
        EXPECT_LE(share, 1) << i;
        least = std::min(least, share);
        most = std::max(most, share);
    }
    EXPECT_LT(least, 0.3);
    EXPECT_GT(most, 0.9) << "no loose bound";
}

TEST(MotionTolerance, IsThatOfTheEyeWhereItIsNearestWhileTheShutterIsOpen)
{
    const Box3d box{Vec3d(-1), Vec3d(1)};
    lod::LevelSettings levels = seen_from_afar(0), nearer = levels;
    nearer.eye.z = 5;
    levels.eye_moves = 35;
    EXPECT_DOUBLE_EQ(lod::motion_tolerance(levels, box), lod::motion_tolerance(nearer, box));
    EXPECT_LT(lod::motion_tolerance(levels, box), 0.2 * lod::motion_tolerance(seen_from_afar(0), box));
}

TEST(MotionDetail, FollowsTheDistanceMovedAcrossTheLineOfSight)
{
    for (const bool is_written : {false, true}) {
        const double across = of_torus(sliding({10, 0, 0}, is_written),
                                       [](const lod::CageMotion& m) { return m.least_distance_across(kEye); });
        EXPECT_LE(across, 10);
        EXPECT_GT(across, 7);  // the lines of sight differ by up to a sixth
        const int level = of_torus(sliding({10, 0, 0}, is_written),
                                   [](const lod::CageMotion& m) { return lod::level_of_motion(seen_from_afar(16), m); });
        const double longest = lod::LevelSettings::kLongestEdge * across / 16;
        EXPECT_LE(lod::edge_length(level), longest);
        EXPECT_GT(lod::edge_length(level + 1), longest);
    }
}

TEST(MotionDetail, IsFullWhereAPointMayStandStillInThePicture)
{
    std::vector<Motion> all;
    all.push_back(sliding({0, 0, 10}, false));  // towards the eye
    for (Motion& motion : motions())
        if (motion.name == "rotating_in_four" || motion.name == "scaling" || motion.name == "morphed" ||
            motion.name == "bending" || motion.name == "inverting" || motion.name == "skinned")
            all.push_back(std::move(motion));
    EXPECT_EQ(all.size(), 7u);
    for (const Motion& motion : all)
        of_torus(motion, [&](const lod::CageMotion& m) {
            EXPECT_EQ(lod::level_of_motion(seen_from_afar(1), m), lod::kFinestLevel) << motion.name;
        });
}

TEST(MotionDetail, IsNoCoarserThanFourPixelsAndNeedsToKnowTheSamples)
{
    const auto level = [&](int strata) {
        return of_torus(sliding({500, 0, 0}, false), [&](const lod::CageMotion& m) {
            EXPECT_EQ(m.least_distance_across(Vec3d(0, 0, 1)), 0) << "the eye is too near";
            return lod::level_of_motion(seen_from_afar(strata), m);
        });
    };
    EXPECT_EQ(level(0), lod::kFinestLevel);
    EXPECT_LE(lod::edge_length(level(1)), 4 * lod::LevelSettings::kLongestEdge * 0.01 * 40);
}

}  // namespace
}  // namespace occam::test
