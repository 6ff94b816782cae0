// Tests of what rays hit in still poses: of cages that jump far away while the shutter is open, and where a ray only grazes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/key_time.h"
#include "tests/support/shape_builders.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

/// Where a torus is at the five keys of a motion along x.
using Places = std::array<double, 5>;

// Returns where it is at a moment.
Vec3d place_at(const Places& places, float time)
{
    const lod::KeyTime at = lod::key_time(time, 4);
    const auto key = static_cast<std::size_t>(at.key);
    return {places[key] + (places[key + 1] - places[key]) * double(at.share), 0, 0};
}

// Returns rays of a camera at (0, 1, 6) towards the torus at the origin, whose times are all over the shutter.
std::vector<accel::Ray> camera_rays(int count)
{
    std::mt19937_64 random(11);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(static_cast<std::size_t>(count));
    for (accel::Ray& ray : rays) {
        ray.origin = {0, 1, 6};
        ray.direction = Vec3f(glm::normalize(Vec3d(3 * uniform() - 1.5, uniform() - 0.5, 0) - ray.origin));
        ray.footprint = {0, 0.04f};
        ray.time = static_cast<float>(uniform());
    }
    return rays;
}

struct JumpingTorus {
    explicit JumpingTorus(const Places& places)
    {
        const NodeId node = place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
        stage.scene.record_shutter(4, [&](double tau) {
            Trs there;
            there.translation = {places[static_cast<std::size_t>(4 * tau)], 0, 0};
            stage.scene.set_transform(node, there);
        });
        stage.scene.refit();
    }
    accel::Frame frame()
    {
        return accel::Frame(stage.scene, stage.topologies, {.eye = {0, 1, 6}, .pixel = {0, 0.04f}, .motion_edges = 0});
    }
    Stage stage;
};

// The camera would be inside of boxes that are grown for places far away, where its rays see infinitely fine levels.
TEST(StillPose, IsFoundInLittleMemoryWhereTheCageJumpsFarAway)
{
    std::vector<accel::Ray> rays = camera_rays(300);
    for (const double far : {1e4, 1e6, 1e8})
        for (const Places& places : {Places{0, 0, far, far, far}, Places{0, far, 0, far, 0}, Places{-far, 0, 0, far, far}}) {
            // Not tested: boxes at the end of a jump grow by ulps of where it began, which is as much as the torus after
            // 1e8.
            if (places[0] != 0 && far > 1e6) continue;
            JumpingTorus torus(places);
            const accel::Frame frame = torus.frame();
            accel::Tracer tracer(frame, std::size_t(64) << 20);
            std::vector<accel::SurfaceHit> hits(rays.size());
            tracer.closest(rays, hits);
            EXPECT_LT(tracer.counters().peak_bytes, std::size_t(16) << 20) << far;
            EXPECT_LT(tracer.counters().diced, 100'000u) << far;
            int found = 0;
            for (const accel::SurfaceHit& hit : hits) found += hit.is_hit();
            EXPECT_TRUE(places[1] != 0 || found > 30) << far << ": " << found;
        }
}

TEST(StillPose, IsHitWhereverTheCageIsOnItsWayFarAway)
{
    // The camera goes with the torus, and its rays have one width everywhere.
    std::vector<accel::Ray> rays = camera_rays(2000);
    for (accel::Ray& ray : rays) ray.footprint = {0.2f, 0};
    const std::vector<accel::Ray> at_rest = rays;
    JumpingTorus still({0, 0, 0, 0, 0});
    const accel::Frame still_frame = still.frame();
    accel::Tracer still_tracer(still_frame, kPlenty);
    std::vector<accel::SurfaceHit> expected(rays.size()), hits(rays.size());
    still_tracer.closest(at_rest, expected);
    for (const double far : {1e3, 1e6})
        for (const Places& places : {Places{0, 0, far, far, far}, Places{far, 0, far, 0, -far}}) {
            JumpingTorus torus(places);
            const accel::Frame frame = torus.frame();
            accel::Tracer tracer(frame, kPlenty);
            for (std::size_t i = 0; i < rays.size(); ++i)
                rays[i].origin = at_rest[i].origin + place_at(places, rays[i].time);
            tracer.closest(rays, hits);
            int both = 0, one = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                one += hits[i].is_hit() != expected[i].is_hit();
                if (!hits[i].is_hit() || !expected[i].is_hit()) continue;
                ++both;
                // Far away, places are rounded.
                EXPECT_NEAR(hits[i].t, expected[i].t, 0.3) << far << ", ray " << i << " at " << rays[i].time;
            }
            EXPECT_GT(both, 400);
            EXPECT_LT(one, both / 20) << far;
        }
}

// Where a micropolygon is edge-on, its area in the world is no larger than the rounding of its corners there, and says
// nothing about where the ray has hit it.
TEST(StillPose, IsHitWhereTheRayIsThoughItGrazesAMicropolygon)
{
    Stage stage;
    const NodeId node = place(stage.scene, stage.scene.add(torus(9, 5)), {0, 0, 0});
    stage.scene.record_shutter(1, [&](double tau) {
        Trs moved;
        moved.translation = {0.3 * tau, 0.2 * tau, 0.1 * tau};
        moved.rotation = {0, std::sin(0.05 * tau), 0, std::cos(0.05 * tau)};
        stage.scene.set_transform(node, moved);
    });
    constexpr int kLevel = -15;
    const accel::Frame frame = stage.frame(kLevel);
    accel::Tracer tracer(frame, kPlenty);
    std::mt19937_64 random(5);
    const auto ray_at = [](double x, double y, float time) {
        accel::Ray ray;
        ray.origin = {x, y, 5};
        ray.direction = {0, 0, -1};
        ray.footprint = {std::ldexp(1.0f, kLevel), 0};
        ray.time = time;
        return ray;
    };
    int found = 0;
    for (int spot = 0; spot < 4; ++spot) {
        const float time = 0.3f + 0.01f * float(spot);
        const double y = 0.02 * spot;
        double inside = 1, outside = 3;
        for (int k = 0; k < 45; ++k) {
            const double middle = 0.5 * (inside + outside);
            const accel::Ray ray = ray_at(middle, y, time);
            accel::SurfaceHit hit;
            tracer.closest({&ray, 1}, {&hit, 1});
            (hit.is_hit() ? inside : outside) = middle;
        }
        std::vector<accel::Ray> rays;
        for (int k = 0; k < 1000; ++k) rays.push_back(ray_at(inside - 1e-6 * double(random() >> 11) * 0x1p-53, y, time));
        std::vector<accel::SurfaceHit> hits(rays.size());
        tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].is_hit()) continue;
            ++found;
            const Vec3d on_ray = rays[i].origin + Vec3d(rays[i].direction) * double(hits[i].t);
            EXPECT_LT(glm::distance(hits[i].position, on_ray), std::ldexp(1.5, kLevel)) << "spot " << spot << ", ray " << i;
        }
    }
    EXPECT_GT(found, 3000);
}

}  // namespace
}  // namespace occam::test
