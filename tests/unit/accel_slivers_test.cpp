// Triangles that are thousands of times longer than wide, and gap triangles, which are as wide as a rounding error.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

// Holds wires along z, each a ribbon of two triangles, and rays at them.
struct Wires {
    explicit Wires(double width)
    {
        Cage cage;
        cage.scheme = Scheme::Triangles;
        for (int i = 0; i < 1500; ++i) {
            const double x = (uniform() - 0.5) * 60 * width, y = (uniform() - 0.5) * 60 * width;
            const double slant_x = (uniform() - 0.5) * 20 * width, slant_y = (uniform() - 0.5) * 20 * width;
            const double begin = -0.5 + 0.1 * uniform(), end = 0.5 - 0.1 * uniform(), angle = 6.283185307 * uniform();
            const Vec3d low(x, y, begin), high(x + slant_x, y + slant_y, end);
            const Vec3d across(width * std::cos(angle), width * std::sin(angle), 0);
            const auto first = static_cast<std::uint32_t>(cage.positions.size());
            for (const Vec3d p : {low, high, high + across, low + across}) cage.positions.push_back(Vec3f(p));
            for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) cage.face_vertices.push_back(first + corner);
            middles.push_back((low + high + across) * 0.5);
        }
        place(stage.scene, stage.scene.add(std::move(cage)), {0, 0, 0});
        stage.scene.refit();
    }
    /// Returns rays from one place to points on wires.
    std::vector<accel::Ray> some_rays(std::size_t count)
    {
        const double x = 0.8 + 0.4 * uniform(), y = 0.1 * uniform(), z = (uniform() - 0.5) * 2;
        std::vector<accel::Ray> rays(count);
        for (accel::Ray& ray : rays) {
            const auto wire = static_cast<std::size_t>(uniform() * double(middles.size()));
            const Vec3d at = middles[wire] + Vec3d(0, 0, 0.8 * (uniform() - 0.5));
            ray.origin = {x, y, z};
            ray.direction = Vec3f(glm::normalize(at - ray.origin));
        }
        return rays;
    }
    double uniform() { return double(random() >> 11) * 0x1p-53; }

    std::mt19937_64 random{3};
    Stage stage;
    std::vector<Vec3d> middles;
};

// The error of t grows with the square of a triangle's length over its width.
TEST(Slivers, AreHitAtTheSamePlacesAloneAndInPackets)
{
    constexpr std::size_t kTogether = 16;
    for (const double width : {3e-5, 1e-5, 3e-6}) {
        Wires wires(width);
        for (const accel::TreeKind kind : {accel::TreeKind::Bvh, accel::TreeKind::Kd}) {
            const accel::Frame frame = wires.stage.frame(-4, lod::LevelMode::PerRay, kind);
            accel::Tracer tracer(frame, kPlenty);
            int hits = 0;
            for (int packet = 0; packet < (is_long() ? 10'000 : 2'000); ++packet) {
                const std::vector<accel::Ray> rays = wires.some_rays(kTogether);
                std::vector<accel::SurfaceHit> together(kTogether);
                tracer.closest(rays, together);
                for (std::size_t i = 0; i < kTogether; ++i) {
                    accel::SurfaceHit alone;
                    tracer.closest({&rays[i], 1}, {&alone, 1});
                    ASSERT_TRUE(same(together[i], alone)) << width << ": " << packet << ' ' << i;
                    hits += alone.is_hit();
                }
            }
            EXPECT_GT(hits, 5'000) << width;
        }
    }
}

// A gap triangle lies beside quads on one side only, also at the far ends of rows and columns.
TEST(Slivers, RaysThatHitGapTrianglesStartAgainNearby)
{
    for (const auto& [around, across, exponent] : {std::tuple(9u, 5u, 5), std::tuple(12u, 4u, 5), std::tuple(5u, 3u, 4)}) {
        const Cage cage = torus(around, across);
        DicedCage diced(cage, 0);
        diced.level_of_largest_exponent(exponent);
        std::vector<Vec3d> middles;
        double longest = 0;
        for (const MeshTriangle& t : diced.triangles())
            if (t.is_gap) middles.push_back(Vec3d(t.v[1]) + diced.posed.anchor);
            else longest = std::max(longest, double(glm::length(t.v[1] - t.v[0])));
        ASSERT_GT(middles.size(), 50u);

        Stage stage;
        place(stage.scene, stage.scene.add(cage), {0, 0, 0});
        stage.scene.refit();
        const accel::Frame frame = stage.frame(diced.posed.level, lod::LevelMode::PerInstance);
        accel::Tracer tracer(frame, kPlenty);
        std::mt19937_64 random(1);
        const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
        int gaps = 0;
        for (int k = 0; k < 60; ++k) {
            // The eye is inside of the tube.
            const double angle = 6.283185307 * uniform(), radius = 0.9 + 0.2 * uniform(), height = 0.1 * (uniform() - 0.5);
            std::vector<accel::Ray> rays;
            for (const Vec3d middle : middles) {
                accel::Ray ray;
                ray.origin = {radius * std::cos(angle), height, radius * std::sin(angle)};
                ray.direction = Vec3f(glm::normalize(middle - ray.origin));
                rays.push_back(ray);
            }
            std::vector<accel::SurfaceHit> hits(rays.size());
            tracer.closest(rays, hits);
            for (const accel::SurfaceHit& hit : hits) {
                if (!hit.is_hit()) continue;
                ++gaps;
                ASSERT_LT(glm::length(hit.to_start), 1.5 * longest) << around << ' ' << across << ' ' << exponent;
            }
        }
        EXPECT_GT(gaps, 1'000);
    }
}

}  // namespace
}  // namespace occam::test
