// Tests what the test of closedness sees: all faces of a cage, and leaks that end at another part of it.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/creased_cages.h"
#include "tests/support/shape_builders.h"
#include "verify/escape_test.h"

namespace occam::test {
namespace {

/// Adds another cage to a cage, scaled and moved. A negative scale turns it inside out.
void join(Cage& cage, const Cage& other, float scale, Vec3f at)
{
    const auto first = static_cast<std::uint32_t>(cage.positions.size());
    for (const Vec3f& p : other.positions) cage.positions.push_back(p * scale + at);
    for (const std::uint32_t v : other.face_vertices) cage.face_vertices.push_back(v + first);
    cage.face_sizes.insert(cage.face_sizes.end(), other.face_sizes.begin(), other.face_sizes.end());
    for (const Crease& crease : other.creases)
        cage.creases.push_back({crease.v0 + first, crease.v1 + first, crease.sharpness});
}

/// Returns a beaker of eight sides with walls of an eighth of its radius.
Cage beaker()
{
    constexpr std::uint32_t kSides = 8;
    Cage cage;
    for (const auto& [radius, y] : {std::pair{1.0f, 0.0f}, {1.0f, 2.0f}, {0.88f, 2.0f}, {0.88f, 0.12f}})
        for (std::uint32_t i = 0; i < kSides; ++i) {
            const float angle = 6.2831853f * float(i) / kSides;
            cage.positions.push_back({radius * std::cos(angle), y, -radius * std::sin(angle)});
        }
    for (std::uint32_t ring = 0; ring < 3; ++ring)
        for (std::uint32_t i = 0; i < kSides; ++i) {
            const std::uint32_t a = ring * kSides + i, b = ring * kSides + (i + 1) % kSides;
            cage.face_vertices.insert(cage.face_vertices.end(), {a, b, b + kSides, a + kSides});
            cage.face_sizes.push_back(4);
        }
    for (std::uint32_t i = 0; i < kSides; ++i) cage.face_vertices.push_back(kSides - 1 - i);
    for (std::uint32_t i = 0; i < kSides; ++i) cage.face_vertices.push_back(3 * kSides + i);
    cage.face_sizes.insert(cage.face_sizes.end(), {kSides, kSides});
    return creased_evenly(cage, 10, 1, 0);
}

Cage cube_beside_a_cube(float scale)
{
    Cage cage = creased_cube(10);
    join(cage, creased_cube(10), scale, {3, 0, 0});
    return cage;
}

VerifiedCage verified(const Cage& cage, std::uint64_t rays)
{
    return verify(cage, Mat4d(1), {.rays = rays, .largest_rate = 8});
}

TEST(Coverage, RaysMeetAllFacesOfASmallPartAndOfThinWalls)
{
    for (const Cage& cage : {cube_beside_a_cube(0.02f), cube_beside_a_cube(1e-6f), beaker(), spindle(40)}) {
        const VerifiedCage found = verified(cage, 20'000);
        EXPECT_EQ(found.not_testable, "");
        EXPECT_GE(found.rays, 20'000u);
        EXPECT_EQ(found.faces_not_met, 0u) << "of " << found.faces;
        EXPECT_TRUE(found.holds());
    }
}

TEST(Coverage, FacesThatNoRayMetAreCounted)
{
    const VerifiedCage found = verified(torus(64, 64), 1);
    EXPECT_EQ(found.rays, 512u);
    EXPECT_GE(found.faces_not_met, 64u * 64u - 512u);
    EXPECT_LT(found.faces_not_met, 64u * 64u);
}

/// Tests a cage that verify() refuses, because a face is left out.
VerifiedCage tested_with_a_hole(const Cage& cage, std::uint32_t hole)
{
    Cage open = cage;
    open.holes = {hole};
    Scene scene;
    const CageSlot& slot = scene.cage(scene.add(open));
    EXPECT_NE(why_not_closed(slot.cage), "");
    const Mat4d place(1);
    VerifiedCage report;
    const VerifySettings settings{.largest_rate = 8};
    EscapeTest({slot, nullptr, nullptr, {&place, 1}, 0}, settings, nullptr, report, 0, 0).run(5'000);
    return report;
}

// Rays that leave through the hole hit the other side of the cavity, or the other cube, from outside.
TEST(Coverage, RaysThatLeaveIntoACavityOrTowardsAnotherPartEscape)
{
    Cage hollow = creased_cube(10);
    join(hollow, creased_cube(10), -0.5f, {0, 0, 0});
    for (const std::uint32_t face : {6u, 9u}) {
        const VerifiedCage found = tested_with_a_hole(hollow, face);
        EXPECT_GT(found.escaped, 0u) << "face " << face << ", " << found.front_side << " hits on front sides";
        EXPECT_FALSE(found.replay.empty());
        EXPECT_FALSE(found.holds());
    }
    EXPECT_TRUE(verified(hollow, 5'000).holds());

    // A cube within the cavity of another: what leaves it hits the cavity, and what leaves the shell hits the cube.
    join(hollow, creased_cube(10), 0.4f, {0, 0, 0});
    for (const std::uint32_t face : {7u, 13u}) EXPECT_GT(tested_with_a_hole(hollow, face).escaped, 0u) << face;
    EXPECT_TRUE(verified(hollow, 5'000).holds());
}

// Eight thousand cubes in one place are more surfaces than a frame takes there (docs/files.md).
TEST(Coverage, AnErrorOfOneCageLeavesTheOthersToBeTested)
{
    Cage many = creased_cube(0);
    many.scheme = Scheme::Bilinear;
    for (int k = 0; k < 13; ++k) join(many, Cage(many), 1, {0, 0, 0});
    Scene scene;
    scene.add_node(scene.root(), {.name = "many", .cages = {scene.add(std::move(many))}});
    scene.add_node(scene.root(), {.name = "one", .cages = {scene.add(prism(7))}});
    const std::vector<VerifiedCage> found = verify(scene, {.rays = 512, .largest_rate = 1});
    ASSERT_EQ(found.size(), 2u);
    for (const VerifiedCage& cage : found) {
        const bool is_one = cage.node == "one";
        EXPECT_EQ(cage.not_testable.empty(), is_one) << cage.not_testable;
        EXPECT_EQ(cage.not_testable.find("surfaces lie in one place") != std::string::npos, !is_one) << cage.not_testable;
        EXPECT_EQ(cage.has_failed, !is_one);
        EXPECT_EQ(cage.rays, is_one ? 512u : 0u);
    }
}

// Overlapping parts have winding numbers of 2. A ray that goes from one into the other hits a front side, and is right.
TEST(Coverage, RaysBetweenPartsThatOverlapDoNotEscape)
{
    Cage cage = creased_cube(10);
    join(cage, creased_cube(10), 1, {0.7f, 0.3f, 0.2f});
    const VerifiedCage found = verified(cage, 20'000);
    EXPECT_GT(found.front_side, 100u);
    EXPECT_TRUE(found.holds()) << found.escaped;
    EXPECT_EQ(found.faces_not_met, 0u);
}

}  // namespace
}  // namespace occam::test
