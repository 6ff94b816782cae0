// Tests that cages are recognised as closed, and points as inside of them (verify/closed.h, verify/mesh_pieces.h).
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "tests/support/made_cages.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"
#include "verify/closed.h"
#include "verify/escape_test.h"
#include "verify/mesh_pieces.h"
#include "verify/starts.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

TEST(WhyNotClosed, NamesTheEdgeOrTheVertex)
{
    Cage cube = prism(4);
    EXPECT_EQ(why_not_closed(cube), "");
    Cage open = cube;
    open.holes = {0};
    const std::uint32_t v = cube.face_vertices[0], w = cube.face_vertices[1];
    EXPECT_EQ(why_not_closed(open).substr(0, 5), "edge ");
    EXPECT_NE(why_not_closed(open).find(" has a face on one side only"), std::string::npos);
    Cage flipped = cube;
    std::reverse(flipped.face_vertices.begin(), flipped.face_vertices.begin() + flipped.face_sizes[0]);
    EXPECT_NE(why_not_closed(flipped).find(" has several faces that pass it in one direction, and none in the other"),
              std::string::npos)
        << why_not_closed(flipped);
    Cage finned = cube;
    finned.positions.push_back({9, 9, 9});
    const auto tip = static_cast<std::uint32_t>(cube.positions.size());
    finned.face_sizes.insert(finned.face_sizes.end(), {3, 3});
    finned.face_vertices.insert(finned.face_vertices.end(), {v, w, tip, w, v, tip});
    EXPECT_EQ(why_not_closed(finned),
              "edge " + std::to_string(std::min(v, w)) + "-" + std::to_string(std::max(v, w)) + " has more than two faces");
    // Two cubes that share one vertex.
    Cage touching = cube;
    const auto count = static_cast<std::uint32_t>(cube.positions.size());
    touching.positions.insert(touching.positions.end(), cube.positions.begin(), cube.positions.end());
    touching.face_sizes.insert(touching.face_sizes.end(), cube.face_sizes.begin(), cube.face_sizes.end());
    for (const std::uint32_t corner : cube.face_vertices) touching.face_vertices.push_back(corner == 3 ? 3 : corner + count);
    EXPECT_EQ(why_not_closed(touching), "vertex 3 has more than one fan of faces");
    Cage none = cube;
    none.holes.clear();
    for (std::uint32_t f = 0; f < cube.face_count(); ++f) none.holes.push_back(f);
    EXPECT_EQ(why_not_closed(none), "it has no face");
}

TEST(MeshPieces, AgreeWithSolidAnglesAndWithAllVertices)
{
    test::Random random(1);
    for (const char* name : {"torus", "cube", "pole_9_creases"}) {
        CageSlot slot;
        slot.cage = made_cage(name);
        const Mat4d place(1);
        Subject subject({slot, nullptr, nullptr, {&place, 1}, 0}, nullptr, 0);
        const Subject::Pair pair = subject.dice(subject.level_of_rate(16), 0);
        const MeshPieces pieces(pair);
        Box3d box;
        for (const Vec3f v : pair.corners) box.add(Vec3d(v));
        int inside = 0;
        for (int i = 0; i < 500; ++i) {
            const double x = random(), y = random(), z = random();
            const Vec3d p = box.lo + box.extent() * Vec3d(x, y, z);
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3f v : pair.corners) nearest = std::min(nearest, glm::distance(Vec3d(v), p));
            EXPECT_EQ(pieces.distance(p, 0), nearest) << name;
            EXPECT_LT(pieces.distance(p, 2 * nearest), 2 * nearest) << name;
            const double winding = winding_number(pair.corners, p);
            EXPECT_EQ(pieces.crossings_along_x(p), static_cast<int>(std::lround(winding))) << name;
            inside += winding > 0.9;
        }
        EXPECT_GT(inside, 20) << name;
        EXPECT_LT(inside, 480) << name;
    }
}

// Whole turns come from many triangles that turn the same way, and go with ones that turn back.
TEST(WindingNumber, IsTheSumOfSolidAngles)
{
    test::Random random(5);
    const auto point = [&](double scale) {
        const double x = random(), y = random(), z = random();
        return (2.0 * Vec3d(x, y, z) - 1.0) * scale;
    };
    double most = 0;
    for (const double scale : {1.0, 1e-40, 1e40})
        for (int i = 0; i < 60; ++i) {
            const Vec3d at = point(0.2 * scale);
            std::vector<Vec3d> corners;
            double angles = 0;
            for (int t = 0; t < 10 * i; ++t) {
                Vec3d p[3];
                for (Vec3d& corner : p) corner = point(scale);
                const bool faces_away = glm::dot(p[0] - at, glm::cross(p[1] - at, p[2] - at)) < 0;
                if (i % 2 == 1 && faces_away) std::swap(p[0], p[1]);  // all turn the same way
                corners.insert(corners.end(), p, p + 3);
                const Vec3d a = glm::normalize(p[0] - at), b = glm::normalize(p[1] - at), c = glm::normalize(p[2] - at);
                angles += 2 *
                          std::atan2(glm::dot(a, glm::cross(b, c)), 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
            }
            const double turns = angles / (4 * 3.14159265358979323846);
            EXPECT_NEAR(winding_number(std::span<const Vec3d>(corners), at), turns, 1e-9) << scale << ' ' << i;
            most = std::max(most, turns);
        }
    EXPECT_GT(most, 20);
    // A corner is where the angles are seen from.
    const std::vector<Vec3d> touching{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    EXPECT_EQ(winding_number(std::span<const Vec3d>(touching), Vec3d(0)), 0);
}

Mat4d stretched(double x)
{
    Mat4d m(1);
    m[0][0] = x;
    return m;
}

// A skinned cage is where its joints take it, whatever its node does.
TEST(Verify, StartsInsideOfSkinnedCagesWhetherNodeOrJointMirrors)
{
    for (const double of_node : {1.0, -1.0})
        for (const double of_joint : {1.0, -1.0}) {
            Scene scene;
            Cage cage = prism(5);
            cage.skin.sets = 1;
            cage.skin.joints.assign(cage.positions.size(), {0, 0, 0, 0});
            cage.skin.weights.assign(cage.positions.size(), {1, 0, 0, 0});
            const NodeId joint = scene.add_node(scene.root(), {.name = "joint", .matrix = stretched(of_joint)});
            const SkinId skin = scene.add(Skin{"skin", {joint}, {}});
            const CageId id = scene.add(std::move(cage));
            scene.add_node(scene.root(), {.name = "skinned", .matrix = stretched(of_node), .cages = {id}, .skin = skin});
            const VerifiedCage found = verify(scene, {.rays = 1'024, .largest_rate = 4}).at(0);
            EXPECT_EQ(found.not_testable, "") << of_node << ' ' << of_joint;
            EXPECT_GT(found.rays, 0u) << of_node << ' ' << of_joint;
            EXPECT_TRUE(found.holds()) << of_node << ' ' << of_joint;
        }
}

// Rays start at several moments. This cage is its own mirror image at nearly all of them, and too thin before.
TEST(Verify, StartsInsideOfACageThatBecomesItsMirrorImage)
{
    Scene scene;
    const CageId id = scene.add(prism(5));
    const NodeId node = scene.add_node(scene.root(), {.name = "cage", .cages = {id}});
    scene.record_shutter(1, [&](double tau) { scene.set_transform(node, stretched(0.01 - 2 * tau)); });
    const VerifiedCage found = verify(scene, {.rays = 1'024, .largest_rate = 4}).at(0);
    EXPECT_EQ(found.not_testable, "");
    EXPECT_GT(found.rays, 0u);
    EXPECT_TRUE(found.holds());
}

/// Adds a node that shows a cage, and moves it while the shutter is open.
NodeId add_moved(Scene& scene, Cage cage, double scale_before, double scale_after)
{
    const NodeId node = scene.add_node(scene.root(), {.name = "cage", .cages = {scene.add(std::move(cage))}});
    scene.record_shutter(1, [&](double tau) {
        Trs place;
        place.translation = {0.5 * tau, 0.15 * tau, 0};
        place.scale = {1, 1, scale_before + (scale_after - scale_before) * tau};
        scene.set_transform(node, place);
    });
    return node;
}

// What is counted is where no point was found, and not where one was found from which no ray has started yet.
TEST(Verify, FindsPointsInsideAtAllMomentsHoweverFewRaysThereAre)
{
    Scene scene;
    add_moved(scene, prism(7), 1, 1);
    const VerifiedCage found = verify(scene, {.rays = 512}).at(0);
    EXPECT_EQ(found.rays, 512u);
    EXPECT_GE(found.starts, 8u);
    EXPECT_EQ(found.moments_not_tested, 0u);
}

// At some moments this cage is thick enough for the level at which the test begins, and at others it is not.
TEST(Verify, LooksAtFinerLevelsAtMomentsAtWhichACageIsThinner)
{
    for (const std::uint64_t seed : {1u, 2u, 3u})
        for (const std::uint64_t rays : {512u, 20'480u}) {
            Scene scene;
            add_moved(scene, prism(4), 0.3, 0.4);
            const VerifiedCage found = verify(scene, {.rays = rays, .seed = seed, .largest_rate = 16}).at(0);
            EXPECT_EQ(found.rays, rays) << seed;
            EXPECT_EQ(found.moments_not_tested, 0u) << seed << ", of " << rays << " rays";
            EXPECT_TRUE(found.holds()) << seed;
        }
}

TEST(Verify, CountsAMomentAtWhichACageHasNoInside)
{
    std::uint64_t all = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        Scene scene;
        add_moved(scene, prism(4), 0, 1);
        const VerifiedCage found = verify(scene, {.rays = 512, .seed = seed, .largest_rate = 4}).at(0);
        EXPECT_EQ(found.not_testable, "");
        EXPECT_LE(found.moments_not_tested, 1u) << seed;  // the first moment is a key
        all += found.moments_not_tested;
    }
    EXPECT_GT(all, 0u);
}

TEST(Verify, SendsTheFirstRaysOfACageThatMovesToEachMomentOnce)
{
    for (const std::uint64_t seed : {1u, 2u, 3u})
        for (const std::size_t views : {1u, 5u, 8u}) {
            Scene scene;
            const NodeId id = add_moved(scene, prism(7), 1, 1);
            scene.refit();
            const Node& node = scene.node(id);
            const std::vector<Mat4d> places = scene.world_from_node_keys(id);
            VerifiedCage report;
            const VerifySettings settings{.seed = seed, .largest_rate = 4};
            EscapeTest test({scene.cage(node.cages[0]), &node, nullptr, places, 1}, settings, nullptr, report, 0, 0);
            test.run(512 * views);
            EXPECT_EQ(report.rays, 512 * views);
            EXPECT_EQ(test.moments_seen(), views) << "seed " << seed;
        }
}

// The test holds meshes in floats. A cage that flies far has the same mesh as one that stands still, in another place.
TEST(Verify, ACageThatFliesFarHasItsMeshAboutWhereItIs)
{
    Scene scene;
    const CageSlot& slot = scene.cage(scene.add(torus()));
    constexpr double kWay = 1e5;
    const Mat4d here(1);
    Mat4d there(1);
    there[3][0] = kWay;
    const Mat4d way[] = {here, there};
    const NodeId node = scene.add_node(scene.root(), {.name = "cage"});
    Subject still({slot, &scene.node(node), nullptr, {&here, 1}, 0}, nullptr, 0);
    Subject flying({slot, &scene.node(node), nullptr, way, 1}, nullptr, 0);
    ASSERT_TRUE(flying.posed().still_pose);
    const int level = still.level_of_rate(8);
    const Subject::Pair expected = still.dice(level, 0);
    for (const float time : {0.0f, 0.3f, 1.0f}) {
        const Subject::Pair found = flying.dice(level, time);
        ASSERT_EQ(found.corners.size(), expected.corners.size()) << time;
        double most_off = 0;
        for (std::size_t i = 0; i < expected.corners.size(); ++i) {
            const Vec3d of_still = still.anchor_at(0) + Vec3d(expected.corners[i]) + Vec3d(kWay * double(time), 0, 0);
            most_off = std::max(most_off, glm::distance(of_still, flying.anchor_at(time) + Vec3d(found.corners[i])));
        }
        EXPECT_LT(most_off, 1e-6) << time;
        EXPECT_LT(flying.radius_at(time), 4.0f) << time;
    }
}

// Few points of this cube are far enough from its faces.
TEST(StartSearch, TriesMorePointsWhereNoFinerLevelFollows)
{
    CageSlot slot;
    slot.cage = creased_cube(10);
    const Mat4d place(1);
    Subject subject({slot, nullptr, nullptr, {&place, 1}, 0}, nullptr, 0);
    for (const bool is_last : {false, true}) {
        int found = 0;
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            occam::Random random(seed);
            Instant instant;
            for (int k = 0; k < 4; ++k) instant.pairs.push_back(subject.dice(subject.level_of_rate(8) + k, 0));
            StartSearch(instant, subject, 4096, random).anywhere(is_last);
            EXPECT_EQ(instant.has_inside, !instant.starts.empty());
            found += instant.has_inside;
        }
        EXPECT_EQ(found >= 18, is_last) << found;
        EXPECT_EQ(found <= 12, !is_last) << found;
    }
}

// Of the box of such a cage little is farther from its faces than edges are long. So points are tried behind faces, and
// finer meshes than elsewhere.
TEST(Verify, StartsInsideOfALongThinCage)
{
    Scene scene;
    Cage pole = prism(12);
    pole.scheme = Scheme::Bilinear;
    Mat4d place(1);
    place[1][1] = 128;
    scene.add_node(scene.root(), {.name = "pole", .matrix = place, .cages = {scene.add(pole)}});
    const VerifiedCage found = verify(scene, {.rays = 1'024}).at(0);
    EXPECT_EQ(found.not_testable, "");
    EXPECT_GT(found.rays, 0u);
    EXPECT_TRUE(found.holds());
}

// A frame makes such a cage when a ray comes near it, and leaves out one that was removed.
TEST(Verify, TestsCagesThatAreMadeOnDemandAndLeavesOutRemovedOnes)
{
    Scene scene;
    OnDemandCage late;
    late.name = "late";
    late.bounds = prism(5).bounds();
    late.make = [] { return prism(5); };
    const CageId on_demand = scene.add(std::move(late)), removed = scene.add(prism(4));
    scene.add_node(scene.root(), {.name = "node", .cages = {removed, on_demand}});
    scene.remove(removed);
    const std::vector<VerifiedCage> found = verify(scene, {.rays = 1'024, .largest_rate = 4});
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].not_testable, "");
    EXPECT_GT(found[0].rays, 0u);
    EXPECT_TRUE(found[0].holds());
}

}  // namespace
}  // namespace occam::test
