// Tests of what rays hit in still poses: of cages that jump far away while the shutter is open.
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
            // Boxes at the end of a jump are grown by ulps of where it began.
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

}  // namespace
}  // namespace occam::test
