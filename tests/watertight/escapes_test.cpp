// No ray leaves a closed cage: at the origin, and at 10^5 sizes from it.
#include <gtest/gtest.h>

#include "tests/support/escapes.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

/// A pole of `valence` edges at both ends of a spindle: triangles all.
Cage spindle(std::uint32_t valence)
{
    Cage cage;
    cage.positions = {{0, 1.5f, 0}, {0, -1.5f, 0}};
    for (std::uint32_t i = 0; i < valence; ++i) {
        const float angle = 6.2831853f * float(i) / float(valence);
        cage.positions.push_back({std::cos(angle), 0.1f * float(i % 2), std::sin(angle)});
    }
    for (std::uint32_t i = 0; i < valence; ++i) {
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % valence;
        cage.face_vertices.insert(cage.face_vertices.end(), {0, b, a, 1, a, b});
        cage.face_sizes.insert(cage.face_sizes.end(), {3, 3});
    }
    return cage;
}

void expect_no_escape(const Cage& cage, int exponent)
{
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    for (const Mat4d& place : {Mat4d(1), far}) {
        const EscapeCount count = count_escapes(cage, place, exponent, rays_per_cage(), 1);
        if (count.starts == 0) GTEST_SKIP() << "no start point whose winding number is 1";
        EXPECT_EQ(count.escaped, 0u) << "of " << count.rays << '\n' << count.replay;
        EXPECT_EQ(count.not_finite, 0u);
    }
}

class Escapes : public testing::TestWithParam<std::string> {};

TEST_P(Escapes, NoRayLeavesAClosedCage)
{
    const Cage cage = load_cage(GetParam());
    expect_no_escape(cage, cage.face_count() > 2000 ? 1 : cage.face_count() > 100 ? 3 : 5);
}

INSTANTIATE_TEST_SUITE_P(Shared, Escapes, testing::ValuesIn(closed_shapes()), shape_test_name);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Escapes);

TEST(Spindle, OfValence360LetsNoRayOut) { expect_no_escape(spindle(360), 3); }
TEST(Spindle, OfValence3LetsNoRayOut) { expect_no_escape(spindle(3), 5); }
TEST(Spindle, OfValence9WithCreasesLetsNoRayOut)
{
    Cage cage = spindle(9);
    cage.creases = {{0, 2, 10}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    expect_no_escape(cage, 5);
}

}  // namespace
}  // namespace occam::test
