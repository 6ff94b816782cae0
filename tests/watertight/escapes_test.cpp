// Tests that no ray leaves a closed cage, at the origin and 10^5 sizes away from it.
#include <gtest/gtest.h>

#include "tests/support/campaign.h"
#include "tests/support/creased_cages.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/escapes.h"
#include "tests/support/shapes.h"

namespace occam::test {
namespace {

/// By default cages are tested far away, too, if their number of vertices is divisible by three.
bool is_left_out(const Cage& cage, const Mat4d& place)
{
    return !is_long() && place != Mat4d(1) && cage.positions.size() % 3 != 0;
}

void expect_no_escape(const Cage& cage, int exponent, const TextureStore* textures = nullptr)
{
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    for (const Mat4d& place : {Mat4d(1), far}) {
        if (is_left_out(cage, place)) continue;
        const EscapeCount count = count_escapes(cage, place, exponent, rays_per_cage(), 1, textures);
        // Some shared cages have no such point, and are tested in the long form alone.
        if (count.starts == 0 && is_long()) GTEST_SKIP() << "no start point whose winding number is 1";
        ASSERT_GT(count.starts, 0u) << "no start point whose winding number is 1";
        EXPECT_EQ(count.escaped, 0u) << "of " << count.rays << '\n' << count.replay;
        EXPECT_EQ(count.not_finite, 0u);
    }
}

/// Returns the log2 of the largest rate of a patch, by which no cage becomes more than some 10^5 triangles.
int exponent_for(const Cage& cage) { return cage.face_count() > 2000 ? 1 : cage.face_count() > 100 ? 3 : 5; }

class Escapes : public testing::TestWithParam<std::string> {};

TEST_P(Escapes, NoRayLeavesAClosedCage)
{
    const Cage cage = load_cage(GetParam());
    expect_no_escape(cage, exponent_for(cage));
}

INSTANTIATE_TEST_SUITE_P(Shapes, Escapes, testing::ValuesIn(chosen_closed_shapes()), shape_test_name);

// Creases of each quarter up to the one that is never smoothed: on all edges, or on one in two or three of them, so that
// lines of creases end in darts. The rays of a cage are divided among the steps. By default two steps are tested, which are
// others for each number of faces.
class EscapesOfCreases : public testing::TestWithParam<std::string> {};
TEST_P(EscapesOfCreases, NoRayLeavesAClosedCage)
{
    const Cage cage = load_cage(GetParam());
    constexpr std::uint64_t kSteps = std::uint64_t(4 * kInfiniteSharpness);
    const std::uint64_t stride = is_long() ? 1 : kSteps / 2;
    for (std::uint64_t step = 1 + cage.face_count() % stride; step <= kSteps; step += stride) {
        const float sharpness = 0.25f * static_cast<float>(step);
        SCOPED_TRACE("sharpness " + std::to_string(sharpness));
        const Cage creased = creased_evenly(cage, sharpness, 1 + step % 3, step);
        const EscapeCount count = count_escapes(creased, Mat4d(1), exponent_for(cage), rays_per_cage() / kSteps, step);
        EXPECT_GT(count.starts, 0u);
        EXPECT_EQ(count.escaped, 0u) << "of " << count.rays << '\n' << count.replay;
        EXPECT_EQ(count.not_finite, 0u);
    }
}
INSTANTIATE_TEST_SUITE_P(Made, EscapesOfCreases, testing::ValuesIn(closed_cages_without_creases()), shape_test_name);

class EscapesOfDisplacedCages : public testing::TestWithParam<int> {};
TEST_P(EscapesOfDisplacedCages, NoRayLeavesAClosedCage)
{
    const DisplacedCage displaced = displaced_case(GetParam());
    expect_no_escape(displaced.cage, is_long() ? 5 : 4, &displaced.textures);
}
INSTANTIATE_TEST_SUITE_P(Closed, EscapesOfDisplacedCages, testing::Range(0, kDisplacedCases),
                         [](const auto& test) { return displaced_case(test.param).name; });

}  // namespace
}  // namespace occam::test
