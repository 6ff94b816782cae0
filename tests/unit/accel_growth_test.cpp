// Tests of cages that grow by a large factor while the shutter is open: rays of each moment see them as if they had that
// size all the time, for about the same work.
#include <gtest/gtest.h>

#include <cmath>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/growth.h"
#include "tests/support/campaign.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr std::size_t kMemoryOfGrowth = std::size_t(1) << 30;

TEST(Growth, TakesSegmentsOfVeryDifferentSizesApart)
{
    using Masks = std::vector<std::uint32_t>;
    const auto groups = [](std::vector<double> radii, int step) { return lod::segments_by_size(radii, step); };
    EXPECT_EQ(groups({1, 2, 16}, 1), Masks{}) << "sizes that are alike";
    EXPECT_EQ(groups({1, 1, 17}, 1), (Masks{2, 1}));
    EXPECT_EQ(groups({1, 1, 17}, 2), (Masks{12, 3}));
    EXPECT_EQ(groups({100, 1, 1, 60, 2}, 1), (Masks{1 | 4 | 8, 2}));
    EXPECT_EQ(groups({1, 1, 1e7, 1e7}, 1), Masks{2 | 4}) << "segments in which the cage is tiny";
    EXPECT_EQ(groups({1, 1, INFINITY}, 1), Masks{});
    EXPECT_EQ(groups({0, 0, 0}, 1), Masks{});
    // Every segment is in one group, unless the cage is tiny there.
    std::vector<double> radii(33);
    for (std::size_t k = 0; k < radii.size(); ++k) radii[k] = std::exp(0.3 * double(k));
    std::uint32_t all = 0;
    for (const std::uint32_t group : lod::segments_by_size(radii, 1)) {
        EXPECT_EQ(all & group, 0u);
        all |= group;
    }
    EXPECT_EQ(all, ~0u);
}

TEST(Growth, MakesEdgesLongerTheMoreACageGrows)
{
    const auto levels = [](double factor) { return lod::coarsened_by_growth(std::vector{factor, 1.0}); };
    EXPECT_EQ(levels(1), 0);
    EXPECT_EQ(levels(8), 0);
    EXPECT_EQ(levels(9), 1);
    EXPECT_EQ(levels(1000), 7);
    EXPECT_EQ(levels(4096), 9);
    EXPECT_EQ(levels(1e30), 9);
    EXPECT_EQ(lod::coarsened_by_growth(std::vector{1.0, 0.0}), 9);
}

// How a torus grows by a factor.
enum class GrowsBy { Node, Parent, Joint, Morph, Vertices };

// A torus that has its own size in the first half of the shutter and grows from then on; or that stands still.
struct GrowingTorus {
    Scene scene;
    lod::TopologyCache topologies;

    GrowingTorus(GrowsBy by, double factor)
    {
        Cage ring = torus(12, 8);
        if (by == GrowsBy::Morph) ring.morph_targets.emplace_back().positions = ring.positions;
        if (by == GrowsBy::Joint) {
            ring.skin.sets = 1;
            ring.skin.joints.assign(ring.positions.size(), {});
            ring.skin.weights.assign(ring.positions.size(), {1, 0, 0, 0});
        }
        const std::vector<Vec3f> rest = ring.positions;
        const CageId cage = scene.add(ring);
        const NodeId parent = scene.add_node(scene.root(), {}), joint = scene.add_node(scene.root(), {});
        NodeDesc desc{.cages = {cage}};
        if (by == GrowsBy::Joint) {
            Skin skin;
            skin.joints = {joint};
            desc.skin = scene.add(std::move(skin));
        }
        const NodeId node = scene.add_node(parent, desc);
        if (factor > 1)
            scene.record_shutter(2, [&](double tau) {
                const double scale = tau > 0.75 ? factor : 1;
                const Trs place{.scale = Vec3d(scale)};
                if (by == GrowsBy::Node) scene.set_transform(node, place);
                if (by == GrowsBy::Parent) scene.set_transform(parent, place);
                if (by == GrowsBy::Joint) scene.set_transform(joint, place);
                if (by == GrowsBy::Morph) scene.set_morph_weights(node, std::vector{float(scale - 1)});
                if (by != GrowsBy::Vertices) return;
                std::vector<Vec3f> moved;
                for (const Vec3f p : rest) moved.push_back(p * float(scale));
                scene.write_vertices(cage, moved);
            });
        scene.refit();
    }
    // Traces rays of the first half of the shutter, which see the torus in its own size.
    std::vector<accel::SurfaceHit> trace(accel::TreeKind tree, std::uint64_t& micropolygons)
    {
        const accel::Frame frame(scene, topologies, {.pixel = {0.02f, 0}, .mode = lod::LevelMode::PerRay}, {.tree = tree});
        Random random(3);
        std::vector<accel::Ray> rays(500);
        for (accel::Ray& ray : rays) {
            ray.direction = Vec3f(random.direction());
            ray.origin = {0.1, 0.2, -0.1};
            ray.footprint = {0.02f, 0};
            ray.time = static_cast<float>(0.5 * random());
        }
        std::vector<accel::SurfaceHit> hits(rays.size());
        accel::Tracer tracer(frame, kMemoryOfGrowth);
        tracer.closest(rays, hits);
        micropolygons = tracer.counters().micropolygons;
        return hits;
    }
};

TEST(GrowingCages, AreDicedForTheSizeThatTheyHave)
{
    std::uint64_t still = 0, growing = 0;
    const auto expected = GrowingTorus(GrowsBy::Node, 1).trace(accel::TreeKind::Bvh, still);
    EveryNth some(3);
    for (const accel::TreeKind tree : {accel::TreeKind::Bvh, accel::TreeKind::Kd})
        for (const GrowsBy by : {GrowsBy::Node, GrowsBy::Parent, GrowsBy::Joint, GrowsBy::Morph, GrowsBy::Vertices})
            for (const double factor : {300.0, 30'000.0}) {
                if (!some.takes()) continue;
                const auto hits = GrowingTorus(by, factor).trace(tree, growing);
                EXPECT_LT(growing, 2 * still) << int(by) << ", " << factor;
                for (std::size_t i = 0; i < hits.size(); ++i) {
                    ASSERT_EQ(hits[i].is_hit(), expected[i].is_hit()) << int(by) << ", " << factor;
                    if (!hits[i].is_hit()) continue;
                    ASSERT_NEAR(hits[i].t, expected[i].t, 1e-3f * expected[i].t);
                }
            }
}

// A ray that cannot see a surface at its time needs no igrid of it, whatever rays it travels with.
TEST(MovingTracer, DicesNothingThatIsHiddenAtTheTimesOfRays)
{
    for (const accel::TreeKind tree : {accel::TreeKind::Bvh, accel::TreeKind::Kd})
        for (const int cubes : {1, 40}) {
            Scene scene;
            const CageId cube = scene.add(creased_cube(10));
            const NodeId group = scene.add_node(scene.root(), {});
            for (int i = 0; i < cubes; ++i)
                scene.add_node(group, {.place = {.translation = {3 * i, 0, 0}}, .cages = {cube}});
            scene.record_shutter(2, [&](double tau) {
                scene.set_visible(group, tau == 0.5);
                scene.set_transform(group, Trs{.translation = {tau, 0, 0}});
            });
            scene.refit();
            lod::TopologyCache topologies;
            const accel::Frame frame(scene, topologies, {.pixel = {0.1f, 0}, .mode = lod::LevelMode::PerRay},
                                     {.tree = tree});
            std::vector<accel::Ray> rays;
            for (int i = 0; i < 64; ++i) {
                // The later half sees the cubes, and passes them.
                accel::Ray& ray = rays.emplace_back();
                ray.origin = {0.6 + 0.001 * i, 5, i % 2 ? 1.6 : 0.2};
                ray.direction = {0, -1, 0};
                ray.footprint = {0.1f, 0};
                ray.time = i % 2 ? 0.75f : 0.25f;
            }
            std::vector<accel::SurfaceHit> hits(rays.size());
            accel::Tracer tracer(frame, kMemoryOfGrowth);
            tracer.closest(rays, hits);
            for (const accel::SurfaceHit& hit : hits) EXPECT_FALSE(hit.is_hit());
            EXPECT_EQ(tracer.counters().micropolygons, 0u);
            for (accel::Ray& ray : rays) ray.time = 0.75f;
            tracer.closest(rays, hits);
            EXPECT_TRUE(hits[0].is_hit());
            EXPECT_GT(tracer.counters().micropolygons, 0u);
        }
}

// Rays that travel together may be in different segments of the shutter. Each is tested against boxes at its own time, so a
// straight path that is recorded in many segments needs no more igrids than in one.
TEST(MovingTracer, DicesNoMoreWhereRaysOfAPacketAreInDifferentSegments)
{
    const auto micropolygons = [](int segments) {
        Scene scene;
        const CageId ring = scene.add(torus(12, 8));
        const NodeId group = scene.add_node(scene.root(), {});
        for (int i = 0; i < 60; ++i) scene.add_node(group, {.place = {.translation = {4 * i, 0, 0}}, .cages = {ring}});
        scene.record_shutter(segments, [&](double tau) {
            scene.set_transform(group, Trs{.translation = {-200 * tau, 0, 0}});
        });
        scene.refit();
        lod::TopologyCache topologies;
        const accel::Frame frame(scene, topologies, {.pixel = {0.1f, 0}, .mode = lod::LevelMode::PerRay},
                                 {.tree = accel::TreeKind::Bvh});
        std::vector<accel::Ray> rays;
        for (int i = 0; i < 64; ++i) {
            accel::Ray& ray = rays.emplace_back();
            ray.origin = {0.9 + 0.001 * i, 5, 0.1};
            ray.direction = {0, -1, 0};
            ray.footprint = {0.1f, 0};
            ray.time = static_cast<float>(0.02 * (i % 50));
        }
        std::vector<accel::SurfaceHit> hits(rays.size());
        accel::Tracer tracer(frame, kMemoryOfGrowth);
        tracer.closest(rays, hits);
        return tracer.counters().micropolygons;
    };
    const std::uint64_t in_one = micropolygons(1);
    EXPECT_GT(in_one, 0u);
    for (const int segments : {4, 32}) EXPECT_LE(micropolygons(segments), in_one + in_one / 10) << segments;
}

}  // namespace
}  // namespace occam::test
