// No ray leaves a closed cage while it moves, whatever the ray's time and footprint (docs/watertightness.md, rules of
// motion).
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "tests/support/campaign.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/motions.h"
#include "tests/support/shape_builders.h"
#include "tests/support/shapes.h"
#include "verify/verify.h"

namespace occam::test {
namespace {

struct Tested {
    std::uint64_t rays = 0;
    std::string why_none;
};

/// At the origin segments overlap by 4 ulps only, so that nothing is hidden; far away as the engine has them.
/// far_alone   tests the cage far away only, unless the long form is run
Tested expect_no_escape(const Cage& cage, const Motion& motion, int largest_rate, std::uint64_t rays, bool far_alone)
{
    Tested tested;
    const double size = 2 * cage.bounds().radius();
    Mat4d far(1);
    far[3] = Vec4d(0.7e5 * size, 0.1e5 * size, -0.7e5 * size, 1);
    for (const Mat4d& place : {Mat4d(1), far}) {
        if (!is_long() && far_alone != (place == far)) continue;
        Scene scene;
        add_moving(scene, cage, motion, place);
        VerifySettings settings;
        settings.rays = rays;
        settings.largest_rate = largest_rate;
        settings.overlap_ulps = place == Mat4d(1) ? 4.0f : 0.0f;
        for (const VerifiedCage& found : verify(scene, settings)) {
            tested.rays += found.rays;
            tested.why_none = found.not_testable;
            if (found.rays == 0) return tested;  // nor elsewhere
            std::string replay;
            for (const std::string& line : found.replay) replay += line + '\n';
            EXPECT_EQ(found.escaped, 0u) << motion.name << ", of " << found.rays << " at " << place[3].x << '\n' << replay;
            EXPECT_EQ(found.not_finite, 0u) << motion.name;
            EXPECT_LE(found.outside, found.rays / 1000) << motion.name;  // or it tests too little
        }
    }
    return tested;
}
void expect_no_escape(const Cage& cage, const Motion& motion, int largest_rate, bool far_alone)
{
    const std::uint64_t rays = is_long() ? blended_rays_per_place() : 2'048;
    EXPECT_GT(expect_no_escape(cage, motion, largest_rate, rays, far_alone).rays, 0u) << motion.name;
}

class MovingCages : public testing::TestWithParam<Motion> {};
TEST_P(MovingCages, LetNoRayOut)
{
    // By default one of the two is at the origin, and the other one far away.
    const bool swapped = GetParam().name.size() % 2 != 0;
    expect_no_escape(torus(), GetParam(), is_long() ? 16 : 4, swapped);
    expect_no_escape(prism(7), GetParam(), is_long() ? 16 : 4, !swapped);
    if (is_long()) expect_no_escape(creased_cube(2.5f), GetParam(), 32, false);
}
INSTANTIATE_TEST_SUITE_P(Motions, MovingCages, testing::ValuesIn(motions()),
                         [](const auto& test) { return test.param.name; });

/// Returns the cage as motions() expect it: two units large, about the origin.
Cage of_two_units(Cage cage)
{
    const Box3d box = cage.bounds();
    const double largest = std::max({box.extent().x, box.extent().y, box.extent().z});
    for (Vec3f& p : cage.positions) p = Vec3f((Vec3d(p) - box.centre()) * (2 / largest));
    return cage;
}

/// Names all closed cages in the long form, else the made ones of each kind.
std::vector<std::string> moving_shapes()
{
    std::vector<std::string> names = chosen_closed_shapes();
    if (!is_long()) std::erase_if(names, [](const std::string& name) { return !name.starts_with("made:"); });
    return names;
}

// Each closed cage in each motion, among which its rays are divided. By default each is tested in one of them, in one place.
class MovingShapes : public testing::TestWithParam<std::string> {};
TEST_P(MovingShapes, LetNoRayOut)
{
    const Cage cage = of_two_units(load_cage(GetParam()));
    const std::vector<Motion> all = motions();
    const int largest_rate = cage.face_count() > 2000 ? 2 : cage.face_count() > 100 ? 8 : 16;
    std::uint64_t tested = 0;
    std::string why_none;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!is_long() && i != cage.positions.size() % all.size()) continue;
        const std::uint64_t rays = is_long() ? 1 + blended_rays_per_place() / all.size() : 256;
        const Tested one = expect_no_escape(cage, all[i], largest_rate, rays, cage.positions.size() % 3 == 0);
        tested += one.rays;
        if (one.rays == 0) why_none = one.why_none;
        // The first motion keeps the shape: where nothing is inside of it then, nothing will be found in the others.
        if (tested == 0 && i == 0) break;
    }
    // Rays start inside. Where no point is certainly inside of the cage, as in one that crosses itself or is thinner than
    // its edges, none can be told to escape.
    if (tested == 0 && is_long()) GTEST_SKIP() << why_none;
    EXPECT_GT(tested, 0u) << why_none;
}
INSTANTIATE_TEST_SUITE_P(Shapes, MovingShapes, testing::ValuesIn(moving_shapes()), shape_test_name);

TEST(MovingSpindle, OfValence9LetsNoRayOut)
{
    Cage cage = spindle(9);
    cage.creases = {{0, 2, 10}, {2, 3, 2.5f}, {4, 1, 0.7f}, {3, 4, 10}};
    for (const Motion& motion : motions())
        if (is_long() || motion.segments == 4) expect_no_escape(cage, motion, is_long() ? 8 : 4, motion.matrix == nullptr);
}

// Rays from the middle of the tube of a torus that flies. Its edges are no shorter than motion allows, and rays ask for
// levels on either side of that one.
TEST(MovingCages, LetNoRayOutWhereMotionMakesThemCoarser)
{
    Scene scene;
    const Vec3d way(6, -3, 1);
    add_moving(scene, torus(), {"flying", 1, [&](double tau) { return moved_by(way * tau); }, {}, {}, {}});
    scene.refit();
    lod::LevelSettings levels;
    levels.eye = {0, 0, 40};
    levels.pixel = {0, 0.001f};
    levels.strata = 32;
    levels.motion_edges = 0;
    levels.overlap_edges = 0;
    levels.overlap_ulps = 4;
    levels.least_coordinate = 5;
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, levels);
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    std::mt19937_64 bits(7);
    const auto random = [&] { return double(bits() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(is_long() ? 4'000'000 : 40'000);
    for (accel::Ray& ray : rays) {
        const double angle = 6.283185307 * random();
        ray.time = static_cast<float>(random());
        ray.origin = Vec3d(0.93 * std::cos(angle), 0, 0.93 * std::sin(angle)) + way * double(ray.time);
        ray.direction = Vec3f(glm::normalize(2.0 * Vec3d(random(), random(), random()) - 1.0));
        ray.footprint = {std::ldexp(1.0f, -8 + static_cast<int>(6 * random())), static_cast<float>(0.3 * random())};
    }
    std::vector<accel::SurfaceHit> hits(rays.size());
    tracer.closest(rays, hits);
    std::size_t escaped = 0;
    int finest = lod::kCoarsestLevel;
    for (const accel::SurfaceHit& hit : hits) {
        escaped += !hit.is_hit();
        finest = std::min(finest, hit.level);
    }
    EXPECT_EQ(escaped, 0u) << "of " << rays.size();
    // Chords of an edge of full detail, 0.057, may cut off a twentieth of that where the control points of the tube are
    // nearest to each other, which tell of a radius of 0.038: they are 0.029 long. Rays ask for edges down to 2^-8.
    EXPECT_EQ(finest, -6);
}

}  // namespace
}  // namespace occam::test
