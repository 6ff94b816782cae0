// Tests that patches which are much longer than wide are found as well as short ones.
#include <gtest/gtest.h>

#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

using lod::LevelMode;

/// Returns long planks in all directions within a cube, each as a row of `pieces` flat quads.
Cage planks(std::uint32_t pieces)
{
    Cage cage;
    cage.scheme = Scheme::Bilinear;
    std::mt19937_64 random(3);
    const auto coordinate = [&] { return double(random() >> 11) * 0x1p-52 - 1; };
    const auto corner = [&] {
        const double x = coordinate(), y = coordinate();
        return Vec3d(x, y, coordinate());
    };
    for (int plank = 0; plank < 400; ++plank) {
        const Vec3d begin = corner(), end = corner();
        const auto first = static_cast<std::uint32_t>(cage.positions.size());
        for (std::uint32_t i = 0; i <= pieces; ++i) {
            const Vec3d at = begin + (end - begin) * (double(i) / pieces);
            cage.positions.push_back(Vec3f(at));
            cage.positions.push_back(Vec3f(at + 0.002));
        }
        for (std::uint32_t i = 0; i < pieces; ++i) {
            const std::uint32_t a = first + 2 * i;
            cage.face_vertices.insert(cage.face_vertices.end(), {a, a + 2, a + 3, a + 1});
            cage.face_sizes.push_back(4);
        }
    }
    return cage;
}

/// Returns how many igrids a ray is tested against, on average.
double igrids_a_ray(std::uint32_t pieces, LevelMode mode)
{
    Stage stage;
    place(stage.scene, stage.scene.add(planks(pieces)), Vec3d(0));
    const accel::Frame frame = stage.frame(-6, mode);
    accel::Tracer tracer(frame, kPlenty);
    const std::vector<accel::Ray> rays = rays_towards(Vec3d(4, 3, 5), stage.scene.bounds(), 1000, 1);
    double sum = 0;
    for (const accel::Ray& ray : rays) {
        accel::SurfaceHit hit;
        sum += double(tracer.observe(ray, hit).igrids);
    }
    return sum / double(rays.size());
}

// The box of a region of a patch held the whole of each side that it touches, since that may be one piece at the coarsest
// levels. So the parts of a long patch had the box of all of it.
TEST(ThinPatches, AreDividedIntoPartsThatRaysTellApart)
{
    for (const LevelMode mode : {LevelMode::PerRay, LevelMode::PerInstance})
        EXPECT_LT(igrids_a_ray(1, mode), 1.5 * igrids_a_ray(16, mode))
            << igrids_a_ray(1, mode) << ' ' << igrids_a_ray(16, mode);
}

}  // namespace
}  // namespace occam::test
