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

// Holds triangles that lie in one plane, far apart, and rays that lie in that plane, too.
struct Coplanar {
    explicit Coplanar(std::uint64_t seed) : random(seed)
    {
        const Vec3d first = direction();
        axes[0] = first;
        axes[1] = glm::normalize(glm::cross(first, direction()));
        cage.scheme = Scheme::Triangles;
        for (std::uint32_t i = 0; i < 3 * kTriangles; ++i) {
            if (i % 3 == 0) middle = point(1);
            cage.positions.push_back(Vec3f(middle + point(0.02)));
            cage.face_vertices.push_back(i);
        }
    }
    accel::Ray ray()
    {
        accel::Ray ray;
        ray.origin = point(1.5);
        ray.direction = Vec3f(glm::normalize(point(1) - ray.origin));
        return ray;
    }
    /// Returns by how much a place is outside of the box of a triangle.
    double beside(std::uint32_t triangle, Vec3d at) const
    {
        Box3d box;
        for (std::size_t p = 0; p < 3; ++p) box.add(Vec3d(cage.positions[3 * std::size_t(triangle) + p]));
        return glm::length(at - glm::clamp(at, box.lo, box.hi));
    }
    double uniform() { return double(random() >> 11) * 0x1p-52 - 1; }
    Vec3d direction()
    {
        const double x = uniform(), y = uniform();
        return glm::normalize(Vec3d(x, y, uniform()));
    }
    Vec3d point(double size)
    {
        const Vec3d along = axes[0] * (uniform() * size);
        return along + axes[1] * (uniform() * size);
    }

    static constexpr std::uint32_t kTriangles = 400;
    std::mt19937_64 random;
    Vec3d axes[2], middle{0};
    Cage cage;
};

// All edge functions of such a triangle are rounding errors, which may have any signs where the ray passes beside it.
TEST(Slivers, TrianglesInWhosePlaneARayLiesAreNotHitBesideIt)
{
    int hits = 0;
    for (std::uint64_t seed = 0; seed < (is_long() ? 400 : 40); ++seed) {
        Coplanar scene(seed);
        Stage stage;
        place(stage.scene, stage.scene.add(scene.cage), {0, 0, 0});
        std::vector<accel::Ray> rays(500);
        for (accel::Ray& ray : rays) ray = scene.ray();
        std::vector<accel::SurfaceHit> in_kd(rays.size()), in_bvh(rays.size());
        for (const accel::TreeKind kind : {accel::TreeKind::Kd, accel::TreeKind::Bvh}) {
            const accel::Frame frame = stage.frame(-4, lod::LevelMode::PerRay, kind);
            accel::Tracer tracer(frame, kPlenty);
            tracer.closest(rays, kind == accel::TreeKind::Kd ? in_kd : in_bvh);
        }
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_TRUE(same(in_kd[i], in_bvh[i])) << seed << ": " << i;
            if (!in_kd[i].is_hit()) continue;
            ++hits;
            const Vec3d at = rays[i].origin + Vec3d(rays[i].direction) * double(in_kd[i].t);
            ASSERT_LT(scene.beside(in_kd[i].face, at), 1e-5) << seed << ": " << i << ", t " << in_kd[i].t;
        }
    }
    EXPECT_GT(hits, 100);
}

}  // namespace
}  // namespace occam::test
