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

/// Returns a closed tube of long quads along an arc, with caps of triangles: at its ends sides of the long patches have a
/// middle, so no level makes one tile of such a patch.
Cage bent_tube()
{
    constexpr std::uint32_t kAround = 16, kRings = 4;
    constexpr double kRadius = 60, kAngle = 2;
    Cage cage;
    const auto point = [&](double along, double out, double up) {
        const double a = kAngle * (along / (kRings - 1) - 0.5);
        cage.positions.push_back(Vec3f(Vec3d((kRadius + out) * std::sin(a), up, (kRadius + out) * std::cos(a) - kRadius)));
    };
    for (std::uint32_t ring = 0; ring < kRings; ++ring)
        for (std::uint32_t i = 0; i < kAround; ++i) {
            const double b = 6.283185307 * i / kAround;
            point(ring, std::cos(b), std::sin(b));
        }
    point(-0.01, 0, 0);
    point(kRings - 0.99, 0, 0);
    const auto face = [&](std::initializer_list<std::uint32_t> corners) {
        cage.face_vertices.insert(cage.face_vertices.end(), corners);
        cage.face_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
    };
    constexpr std::uint32_t kLast = (kRings - 1) * kAround, kTip = kRings * kAround;
    for (std::uint32_t i = 0; i < kAround; ++i) {
        const std::uint32_t j = (i + 1) % kAround;
        for (std::uint32_t ring = 0; ring + 1 < kRings; ++ring) {
            const std::uint32_t at = ring * kAround;
            face({at + i, at + j, at + kAround + j, at + kAround + i});
        }
        face({j, i, kTip});
        face({kLast + i, kLast + j, kTip + 1});
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

// At coarse levels the sides of such patches are single pieces, which the boxes of their halves have to hold.
TEST(ThinPatches, AreFoundAtLevelsAtWhichTheirSidesAreOnePiece)
{
    Stage stage;
    place(stage.scene, stage.scene.add(bent_tube()), Vec3d(0));
    constexpr int kCoarse = 10;
    for (const accel::TreeKind kind : {accel::TreeKind::Kd, accel::TreeKind::Bvh}) {
        const accel::Frame each = stage.frame(kCoarse, LevelMode::PerRay, kind),
                           one = stage.frame(kCoarse, LevelMode::PerInstance, kind);
        // The boxes of a shared tree stay those of the items.
        accel::SharedTree each_tree(each, kPlenty), one_tree(one, kPlenty);
        accel::Tracer by_ray(each_tree), by_instance(one_tree);
        std::vector<accel::Ray> rays = rays_towards(Vec3d(30, 90, 120), stage.scene.bounds(), 20'000, 2);
        for (accel::Ray& ray : rays) ray.footprint = {std::ldexp(1.0f, kCoarse), 0};
        std::vector<accel::SurfaceHit> found(rays.size()), expected(rays.size());
        by_ray.closest(rays, found);
        by_instance.closest(rays, expected);
        int hits = 0, different = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            hits += expected[i].is_hit();
            different += found[i].t != expected[i].t;
        }
        EXPECT_GT(hits, 500);
        EXPECT_EQ(different, 0);
    }
}

}  // namespace
}  // namespace occam::test
