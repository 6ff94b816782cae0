// Tests that no ray leaves a closed cage, whatever its footprint: constant, growing, shrinking or steep. Each ray blends the
// surface for itself between two levels, and goes from pair to pair near the hit (watertightness, rules 10 to 17).
#include <gtest/gtest.h>

#include <cmath>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "io/builtin/pieces.h"
#include "tests/support/campaign.h"
#include "tests/support/creased_cages.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/made_cages.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"
#include "tests/support/tracer_stage.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

/// Tests a cage at the origin, where segments overlap by 4 ulps only, so that no fault is hidden, and far away, where they
/// overlap as in the engine. By default cages are tested far away if their number of vertices is divisible by three.
void expect_no_escape(const Cage& cage, const TextureStore* textures = nullptr)
{
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    VerifySettings settings;
    settings.rays = blended_rays_per_place();
    settings.largest_rate = cage.face_count() > 2000 ? 2 : cage.face_count() > 100 ? 8 : 32;
    // The boxes of displaced surfaces include the bound of the displacement. Where edges are much finer than that, many
    // boxes overlap, and rays are slow.
    if (textures) {
        settings.largest_rate = is_long() ? 8 : 4;
        settings.rays /= 5;
    }
    for (const Mat4d& place : {Mat4d(1), far}) {
        if (!is_long() && place != Mat4d(1) && cage.positions.size() % 3 != 0) continue;
        settings.overlap_ulps = place == Mat4d(1) ? 4.0f : 0.0f;
        const VerifiedCage found = verify(cage, place, settings, textures);
        // Rays start inside. Where nothing is certainly inside, as in a surface that crosses itself, none can be told to
        // escape. Only some shared cages are like that, of those that the long form tests.
        if (found.rays == 0 && is_long()) GTEST_SKIP() << found.not_testable;
        ASSERT_GT(found.rays, 0u) << found.not_testable;
        std::string replay;
        for (const std::string& line : found.replay) replay += line + '\n';
        EXPECT_EQ(found.escaped, 0u) << "of " << found.rays << " at " << place[3].x << '\n' << replay;
        EXPECT_EQ(found.not_finite, 0u);
        EXPECT_LE(found.outside, found.rays / 10'000);  // otherwise the test covers too little
    }
}

class Levels : public testing::TestWithParam<std::string> {};
TEST_P(Levels, LetNoRayOut) { expect_no_escape(load_cage(GetParam())); }
INSTANTIATE_TEST_SUITE_P(Shapes, Levels, testing::ValuesIn(chosen_closed_shapes()), shape_test_name);

// Creases as in EscapesOfCreases (escapes_test.cpp). The rays of a cage are divided among the steps.
class LevelsOfCreases : public testing::TestWithParam<std::string> {};
TEST_P(LevelsOfCreases, LetNoRayOut)
{
    const Cage cage = load_cage(GetParam());
    constexpr std::uint64_t kSteps = std::uint64_t(4 * kInfiniteSharpness);
    const std::uint64_t stride = is_long() ? 1 : kSteps / 2;
    VerifySettings settings;
    settings.rays = 2 * blended_rays_per_place() / kSteps;
    settings.largest_rate = cage.face_count() > 60 ? 8 : 32;
    std::uint64_t steps = 0, tested = 0;
    for (std::uint64_t step = 1 + cage.face_count() % stride; step <= kSteps; step += stride, ++steps) {
        const float sharpness = 0.25f * static_cast<float>(step);
        settings.seed = step;
        const VerifiedCage found = verify(creased_evenly(cage, sharpness, 1 + step % 3, step), Mat4d(1), settings);
        tested += found.rays > 0;
        EXPECT_TRUE(found.holds()) << found.escaped << " of " << found.rays << ", sharpness " << sharpness << '\n'
                                   << (found.replay.empty() ? "" : found.replay.front());
    }
    // The creases of high poles leave some cages with an inside that is thinner than their longest edges.
    EXPECT_GT(2 * tested, steps);
}
INSTANTIATE_TEST_SUITE_P(Made, LevelsOfCreases, testing::ValuesIn(closed_cages_without_creases()), shape_test_name);

/// Returns all closed pieces in the long form, else every third one.
std::vector<Cage> chosen_closed_pieces()
{
    std::vector<Cage> chosen;
    EveryNth tested(3);
    for (Cage& piece : builtin::closed_pieces())
        if (tested.takes()) chosen.push_back(std::move(piece));
    return chosen;
}

class LevelsOfPieces : public testing::TestWithParam<Cage> {};
TEST_P(LevelsOfPieces, LetNoRayOut) { expect_no_escape(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Closed, LevelsOfPieces, testing::ValuesIn(chosen_closed_pieces()), [](const auto& test) {
    std::string name = test.param.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    return name;
});

class LevelsOfDisplacedCages : public testing::TestWithParam<int> {};
TEST_P(LevelsOfDisplacedCages, LetNoRayOut)
{
    const DisplacedCage displaced = displaced_case(GetParam());
    expect_no_escape(displaced.cage, &displaced.textures);
}
INSTANTIATE_TEST_SUITE_P(Closed, LevelsOfDisplacedCages, testing::Range(0, kDisplacedCases),
                         [](const auto& test) { return displaced_case(test.param).name; });

// A mirrored cage winds the other way around, and is as closed.
TEST(LevelsOfMirroredCage, LetNoRayOut)
{
    Mat4d mirrored(1);
    mirrored[0][0] = -1;
    const VerifiedCage found = verify(made_cage("torus"), mirrored, {.rays = 20'480, .largest_rate = 8});
    EXPECT_EQ(found.not_testable, "");
    EXPECT_EQ(found.escaped, 0u);
    EXPECT_EQ(found.front_side, 0u) << "the inside is the back";
}

// A cage that is small beside its distance from the origin of the tree's floats ends with a level that their steps tell
// apart (rule 35). Rays see pairs around that level, coarser ones and finer ones, which are all the same.
TEST(RoundedLevels, LetNoRayOutOfASmallCageInALargeWorld)
{
    constexpr double kSize = 1e-4;
    Stage stage;
    const CageId small = stage.scene.add(torus(12, 8, false));
    place(stage.scene, small, {0, 0, 0}, kSize);
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0}, 10);
    stage.scene.refit();
    const accel::Frame frame(stage.scene, stage.topologies, {.eye = {0, 0, 8}, .pixel = {0, 0}});
    accel::Tracer tracer(frame, kPlenty);
    Random random(3);
    std::vector<accel::Ray> rays(is_long() ? 1'000'000 : 20'000);
    for (accel::Ray& ray : rays) {
        const double a = 6.283185307 * random();
        ray.origin = kSize * (Vec3d(std::cos(a), 0, std::sin(a)) + 0.2 * random.direction());
        ray.direction = Vec3f(random.direction());
        const auto width = static_cast<float>(kSize * std::exp2(-20 * random()) * 0.05);
        const auto slope = static_cast<float>(std::exp2(-12 * random()) * 0.1);
        switch (static_cast<int>(random() * 3)) {
            case 0:
                ray.footprint = {width, 0};
                break;
            case 1:
                ray.footprint = {random() < 0.5 ? width : 0, slope};
                break;
            default:
                ray.footprint = {width, -slope};
        }
    }
    std::vector<accel::SurfaceHit> hits(rays.size());
    tracer.closest(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i)
        EXPECT_TRUE(hits[i].cage == small && hits[i].back_side && double(hits[i].t) < 3 * kSize) << "ray " << i;
}

}  // namespace
}  // namespace occam::test
