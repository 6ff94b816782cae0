// Tests of the detail of cages that move (lod/cage_motion.h): what motion makes coarser, and how many keys they need.
#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "lod/cage_motion.h"
#include "lod/pose_cage.h"
#include "scenegraph/shutter.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/displaced_cages.h"
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

int level_seen_from_afar(int strata, const lod::CageMotion& motion)
{
    return lod::level_of_motion(seen_from_afar(strata), motion, lod::CageCurvature());
}

// Calls what(motion) for a cage that moves so.
template <class What>
auto of_cage(Scene& scene, const Cage& cage, const Motion& motion, What&& what)
{
    const NodeId id = add_moving(scene, cage, motion);
    scene.refit();
    const Node& node = scene.node(id);
    const std::vector<Mat4d> moving = scene.world_from_node_keys(id);
    const Mat4d placed = scene.world_from_node(id);
    const std::span<const Mat4d> matrices = moving.empty() ? std::span(&placed, 1) : std::span(moving);
    const CageSlot& slot = scene.cage(node.cages.front());
    return what(lod::CageMotion(slot, node, scene.find(node.skin), matrices, scene.shutter_segments()));
}

template <class What>
auto of_torus(const Motion& motion, What&& what)
{
    Scene scene;
    return of_cage(scene, torus(), motion, what);
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
    Cage square;  // flat, so that long edges cut nothing off
    square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    square.face_vertices = {0, 1, 2, 3};
    square.face_sizes = {4};
    const auto of_square = [&](auto&& what) {
        Scene scene;
        return of_cage(scene, square, sliding({10, 0, 0}, false), what);
    };
    const double across = of_square([](const lod::CageMotion& m) { return m.least_distance_across(kEye); });
    EXPECT_LE(across, 10);
    EXPECT_GT(across, 7);  // the lines of sight differ by up to a sixth
    const int level = of_square([](const lod::CageMotion& m) { return level_seen_from_afar(16, m); });
    const double longest = lod::LevelSettings::kLongestEdge * across / 16;
    EXPECT_LE(lod::edge_length(level), longest);
    EXPECT_GT(lod::edge_length(level + 1), longest);
}

// Each of these bends within less than twice its edges, which the normals of its vertices alone do not tell.
TEST(MotionDetail, SeesHowASurfaceBendsBetweenItsVertices)
{
    const auto sheet = [](auto&& height) {
        Cage cage;
        for (int j = 0; j <= 8; ++j)
            for (int i = 0; i <= 8; ++i) cage.positions.push_back({float(i), float(j), height(i, j)});
        for (std::uint32_t j = 0; j < 8; ++j)
            for (std::uint32_t i = 0; i < 8; ++i) {
                const std::uint32_t a = j * 9 + i;
                cage.face_vertices.insert(cage.face_vertices.end(), {a, a + 1, a + 10, a + 9});
                cage.face_sizes.push_back(4);
            }
        return cage;
    };
    const auto bumps = [](int i, int j) { return (i + j) % 2 ? 0.5f : -0.5f; };
    const auto grooves = [](int i, int) { return i % 2 ? 0.5f : -0.5f; };
    const auto twisted = [](int i, int j) { return 0.25f * float(i - 4) * float(j - 4); };
    EXPECT_LT(lod::least_radius_of_curvature(sheet(bumps)), 2);
    EXPECT_LT(lod::least_radius_of_curvature(sheet(grooves)), 2);
    EXPECT_LT(lod::least_radius_of_curvature(sheet(twisted)), 4) << "the surface z = x y / 4 bends with a radius of 4";
    EXPECT_EQ(lod::least_radius_of_curvature(sheet([](int, int) { return 0.0f; })), std::numeric_limits<double>::infinity());
}

// The tube of the torus is thinner than a pixel, and a chord of a pixel would cut off much of it.
TEST(MotionDetail, OfThinCagesIsThatOfStillOnes)
{
    const double pixel_edge = lod::LevelSettings::kLongestEdge * 0.01 * 40;
    const auto edge = [](const lod::CageMotion& m) { return lod::edge_length(level_seen_from_afar(1, m)); };
    EXPECT_LT(of_torus(sliding({10, 0, 0}, false), edge), 0.5 * pixel_edge);
    Cage large = torus();
    for (Vec3f& p : large.positions) p *= 8.0f;
    Scene scene;
    EXPECT_GE(of_cage(scene, large, sliding({10, 0, 0}, false), edge), 2 * of_torus(sliding({10, 0, 0}, false), edge))
        << "edges are as long as the root of eight allows, rounded to a power of two";
}

// A squashed cage bends where its map, not the axes of its object, squeezes it.
TEST(MotionDetail, OfSquashedCagesIsTheSameHoweverTheyAreTurnedBefore)
{
    Mat4d squashed(1);
    squashed[1][1] = 0.02;
    const auto radius = [&](const Mat4d& turned) {
        Motion motion = sliding({10, 0, 0}, false);
        motion.matrix = [&](double tau) { return moved_by(Vec3d(10 * tau, 0, 0)) * squashed * turned; };
        return of_torus(motion, [](const lod::CageMotion& m) { return m.least_radius(lod::CageCurvature()); });
    };
    const double expected = 0.02 * 0.02 * lod::least_radius_of_curvature(torus());
    EXPECT_NEAR(radius(Mat4d(1)), expected, 1e-9 * expected);
    for (const double angle : {0.01, 0.5, 0.7853981634, 3.0})
        for (const Vec3d axis : {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0.6, 0.48, 0.64)})
            EXPECT_NEAR(radius(glm::rotate(Mat4d(1), angle, axis)), expected, 1e-9 * expected) << angle;
    for (int axis = 0; axis < 3; ++axis) squashed[axis] *= 3.0;
    EXPECT_NEAR(radius(glm::rotate(Mat4d(1), 0.5, Vec3d(0, 0, 1))), 3 * expected, 1e-9 * expected);
}

TEST(MotionDetail, FollowsTheCageWhereItsVerticesAreWritten)
{
    Scene scene;
    const CageSlot& slot = scene.cage(scene.add(torus()));
    lod::TopologyCache topologies;
    const auto radius = [&] { return topologies.get(slot).curvature.least_radius(slot.cage); };
    const double before = radius();
    EXPECT_EQ(before, lod::least_radius_of_curvature(slot.cage));
    std::vector<Vec3f> larger = slot.cage.positions;
    for (Vec3f& p : larger) p *= 8.0f;
    scene.write_vertices(slot.id, larger);
    EXPECT_NEAR(radius(), 8 * before, 1e-9 * before);
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
        of_torus(motion,
                 [&](const lod::CageMotion& m) { EXPECT_EQ(level_seen_from_afar(1, m), lod::kFinestLevel) << motion.name; });
}

// Nothing says how sharply these bend where they are seen, and displacement may be finer than the cage.
TEST(MotionDetail, IsFullForWhatDeformsOrIsDisplaced)
{
    const auto level = [](const lod::CageMotion& m) { return level_seen_from_afar(1, m); };
    EXPECT_GT(of_torus(sliding({10, 0, 0}, false), level), lod::kFinestLevel);
    EXPECT_EQ(of_torus(sliding({10, 0, 0}, true), level), lod::kFinestLevel);
    Cage charted = torus();
    add_charts(charted);
    DisplacedCage displaced("displaced", charted, 0.01f, 3);
    EXPECT_EQ(of_cage(displaced.scene, displaced.cage, sliding({10, 0, 0}, false), level), lod::kFinestLevel);
    Cage morphed = torus();
    morphed.morph_targets.emplace_back().positions = morphed.positions;
    morphed.morph_weights = {0.5f};
    Scene scene;
    EXPECT_EQ(of_cage(scene, morphed, sliding({10, 0, 0}, false), level), lod::kFinestLevel);
}

// A fin that is as long as the cage turns with its joint by two radians; straight lines between few keys would cut it short.
TEST(MotionKeys, OfADisplacedSkinFollowWhatTurnsWithItsJoints)
{
    Cage charted = torus();
    for (Vec3f& p : charted.positions) p *= 0.05f;
    const auto segments = [&](float bound) {
        Cage cage = charted;
        add_charts(cage);
        DisplacedCage displaced("fin", cage, bound, 3);
        Motion motion{"skinned", 32, {}, {}, {}, {}};
        motion.upper_joint = [](double tau) { return glm::rotate(Mat4d(1), 2 * tau, Vec3d(0, 1, 0)); };
        return of_cage(displaced.scene, displaced.cage, motion, [](const lod::CageMotion& m) { return m.segments(0.005); });
    };
    EXPECT_GE(segments(1), 8) << "a chord of 2 radians / 8 leaves its arc by 1 / 128 of the radius";
    EXPECT_LT(segments(0.001f), segments(1));
}

// One face of many turns.
TEST(MotionKeys, OfWrittenVerticesFollowEachFaceThatTurns)
{
    for (const int side : {4, 100}) {
        Cage cage;
        for (int j = 0; j <= side; ++j)
            for (int i = 0; i <= side; ++i) cage.positions.push_back({float(i), float(j), 0});
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                const auto a = static_cast<std::uint32_t>(j * (side + 1) + i), up = static_cast<std::uint32_t>(side + 1);
                cage.face_vertices.insert(cage.face_vertices.end(), {a, a + 1, a + up + 1, a + up});
                cage.face_sizes.push_back(4);
            }
        add_charts(cage);
        DisplacedCage displaced("one", cage, 1, 3);
        Motion motion{"one face turns", 32, {}, {}, {}, {}};
        motion.vertex = [](Vec3f p, double tau) {
            if (p.x < 1 || p.x > 2 || p.y < 1 || p.y > 2) return p;
            const Vec3f d = p - Vec3f(1.5f, 1.5f, 0);
            const auto c = static_cast<float>(std::cos(2 * tau)), s = static_cast<float>(std::sin(2 * tau));
            return Vec3f(1.5f + c * d.x, p.y, s * d.x);
        };
        EXPECT_GE(
            of_cage(displaced.scene, displaced.cage, motion, [](const lod::CageMotion& m) { return m.segments(0.02); }), 8)
            << side;
    }
}

// A torus is flattened to a 50th of its height along straight lines. Half-way its normals are not half-way between those at
// both ends.
TEST(MotionKeys, OfWhatFlattensFollowItsNormals)
{
    const auto segments = [](const Cage& cage, const std::function<Vec3f(Vec3f, float)>& vertex) {
        Motion motion{"straight", 32, {}, {}, {}, {}};
        motion.vertex = [&](Vec3f p, double tau) { return vertex(p, static_cast<float>(tau)); };
        Scene scene;
        return of_cage(scene, cage, motion, [](const lod::CageMotion& m) { return m.segments(100); });
    };
    const int count = segments(torus(), [](Vec3f p, float tau) { return Vec3f(p.x, p.y * (1 - 0.98f * tau), p.z); });
    EXPECT_GE(count, 4);
    for (int k = 0; k < count; ++k)
        for (const double slope : {0.1, 1.0, 10.0}) {
            const auto normal = [&](double tau) { return glm::normalize(Vec3d(slope * (1 - 0.98 * tau), 1, 0)); };
            const Vec3d between = glm::normalize(normal(k / double(count)) + normal((k + 1) / double(count)));
            EXPECT_GT(glm::dot(between, normal((k + 0.5) / count)), std::cos(1.1 * kMostTurn)) << slope;
        }
    EXPECT_EQ(segments(torus(), [](Vec3f p, float tau) { return p + Vec3f(0, 0, 9 * tau); }), 1) << "sliding turns nothing";
    Cage triangle;
    triangle.scheme = Scheme::Triangles;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.face_vertices = {0, 1, 2};
    EXPECT_EQ(segments(triangle, [](Vec3f p, float tau) { return p + Vec3f(0, 0, tau * p.x); }), 1)
        << "the normal of a triangle is that of its corners at each time";
}

TEST(MotionDetail, IsNoCoarserThanFourPixelsAndNeedsToKnowTheSamples)
{
    const auto level = [&](int strata) {
        return of_torus(sliding({500, 0, 0}, false), [&](const lod::CageMotion& m) {
            EXPECT_EQ(m.least_distance_across(Vec3d(0, 0, 1)), 0) << "the eye is too near";
            return level_seen_from_afar(strata, m);
        });
    };
    EXPECT_EQ(level(0), lod::kFinestLevel);
    EXPECT_LE(lod::edge_length(level(1)), 4 * lod::LevelSettings::kLongestEdge * 0.01 * 40);
}

}  // namespace
}  // namespace occam::test
