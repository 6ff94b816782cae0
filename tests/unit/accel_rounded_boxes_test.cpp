// Tests of what rays build where things are small beside their distance from the origin of the tree's floats: they ask for
// details that boxes of these floats cannot tell apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/pose_cage.h"
#include "lod/ray_levels.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

lod::LevelSettings at_eye(Vec3d eye)
{
    lod::LevelSettings levels;
    levels.eye = eye;
    levels.shading_rate = 1 / lod::LevelSettings::kLongestEdge;
    levels.motion_edges = 0;
    return levels;
}

/// Counts what rays ask for, each in a tree of its own.
struct Asked {
    std::vector<accel::SurfaceHit> hits;
    std::uint64_t most_grids = 0;  ///< built by one ray
};
Asked ask(const accel::Frame& frame, const std::vector<accel::Ray>& rays)
{
    Asked asked;
    asked.hits.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        accel::Tracer tracer(frame, kPlenty);
        tracer.closest({&rays[i], 1}, {&asked.hits[i], 1});
        asked.most_grids = std::max(asked.most_grids, tracer.counters().grids);
    }
    return asked;
}

// The large torus moves the eye's side of the scene away from the small one.
TEST(RoundedBoxes, OfASmallCageInALargeWorldAreMetByRaysWithoutWidth)
{
    const Vec3d eye{0, 0, 8};
    for (const double size : {1e-2, 1e-3, 1e-4, 1e-5}) {
        Random random(5);
        std::vector<accel::Ray> rays(20);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays[i].direction = Vec3f(random.direction());
            const Vec3d target = size * Vec3d(1, 0, 0) + 0.2 * size * random.direction();
            rays[i].origin = target - (i % 2 == 0 ? 4 * size : 3.0) * Vec3d(rays[i].direction);
        }
        const auto answers = [&](bool has_world) {
            Stage stage;
            place(stage.scene, stage.scene.add(torus()), {0, 0, 0}, size);
            if (has_world) place(stage.scene, stage.scene.add(torus()), {0, 0, 0}, 10);
            stage.scene.refit();
            const accel::Frame frame(stage.scene, stage.topologies, at_eye(eye));
            return ask(frame, rays);
        };
        const Asked alone = answers(false), in_world = answers(true);
        EXPECT_LE(in_world.most_grids, 50u) << size;
        int both = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!alone.hits[i].is_hit() || !in_world.hits[i].is_hit()) continue;
            ++both;
            EXPECT_NEAR(in_world.hits[i].t, alone.hits[i].t, 4e-6) << size << ", ray " << i;
        }
        EXPECT_GE(both, 10) << size;
    }
}

// Where a cage is far from the eye, segments of the ray overlap by more than the beam is wide.
TEST(RoundedBoxes, OfACageThatFliesFarAreMetByBeamsThatBeginAtIt)
{
    for (const double far : {3e1, 1e4, 1e5}) {
        Stage stage;
        const NodeId node = place(stage.scene, stage.scene.add(torus(12, 5)), {0, 0, 0});
        stage.scene.record_shutter(1, [&](double tau) {
            Trs there;
            there.translation = {far * tau, 0, 0};
            stage.scene.set_transform(node, there);
        });
        stage.scene.refit();
        for (const float spread : {0.0f, 0.05f}) {
            Random random(7);
            std::vector<accel::Ray> rays(20);
            for (accel::Ray& ray : rays) {
                ray.time = 0.7f;
                ray.origin = Vec3d(1.0 + far * double(ray.time), 0, 0.2);
                ray.direction = Vec3f(random.direction());
                ray.footprint = {0, spread};
            }
            const accel::Frame frame(stage.scene, stage.topologies, at_eye(Vec3d(0)));
            const Asked asked = ask(frame, rays);
            EXPECT_LE(asked.most_grids, 60u) << far << ", spread " << spread;
            for (const accel::SurfaceHit& hit : asked.hits) EXPECT_TRUE(hit.is_hit()) << far << ", spread " << spread;
        }
    }
}

// A ray without a width sees as much detail at a small cage whatever else is in the scene.
TEST(RoundedBoxes, OfAVeryLargeCageLeaveThinRaysTheirDetail)
{
    constexpr double kSize = 0.01;
    Random random(5);
    std::vector<accel::Ray> rays(20);
    for (accel::Ray& ray : rays) {
        ray.direction = Vec3f(random.direction());
        ray.origin = kSize * (Vec3d(1, 0, 0) + 0.1 * random.direction()) - 0.1 * Vec3d(ray.direction);
    }
    const auto answers = [&](double world) {
        Stage stage;
        place(stage.scene, stage.scene.add(torus()), {0, 0, 0}, kSize);
        if (world > 0) place(stage.scene, stage.scene.add(torus()), {0, 0, 0}, world);
        stage.scene.refit();
        const accel::Frame frame(stage.scene, stage.topologies, at_eye({0, 0, 0.08}));
        return ask(frame, rays);
    };
    const Asked alone = answers(0);
    for (const double world : {1e3, 1e6, 1e10}) {
        const Asked in_world = answers(world);
        int met = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!alone.hits[i].is_hit()) continue;
            ++met;
            EXPECT_NEAR(in_world.hits[i].t, alone.hits[i].t, 1e-6) << world << ", ray " << i;
        }
        EXPECT_GE(met, 15);
    }
}

TEST(RoundedBoxes, LetABeamBeginWithEdgesThatItHasWhereSegmentsAreNoLongerThanRounding)
{
    const lod::LevelSettings settings;
    for (const float coordinate : {0.0f, 1.0f, 7e3f}) {
        lod::RayLevels<float> table;
        ASSERT_TRUE(table.set({0, 0.05f}, 0, 1, coordinate, settings));
        const float shortest = 4 * 16 * 0x1p-24f * coordinate;
        EXPECT_LE(lod::edge_length(table.finest), std::max(0.05f * shortest, 0.05f * 0x1p-15f)) << coordinate;
        EXPECT_GT(lod::edge_length(table.finest + 1), 0.05f * shortest) << coordinate;
        // A ray that starts on a mesh sees that mesh, whatever is rounded.
        ASSERT_TRUE(table.set({0, 0.05f, 0x1p-12f}, 0, 1, coordinate, settings));
        EXPECT_EQ(table.finest, -12) << coordinate;
    }
}

class FinestLevel {
public:
    FinestLevel() : cage_(scene_.add(torus())), node_(place(scene_, cage_, {0, 0, 0})) { scene_.refit(); }
    /// Returns the finest level of the cage that is at these places at the keys of its motion.
    int at(const std::vector<Vec3d>& places, std::optional<Vec3d> origin)
    {
        lod::LevelSettings levels = at_eye(Vec3d(0));
        levels.origin = origin;
        std::vector<Mat4d> matrices;
        for (const Vec3d at : places) matrices.push_back(moved(at.x, at.y, at.z));
        Arena arena;
        lod::DeformCounters counters;
        const CageSlot& slot = scene_.cage(cage_);
        return lod::pose_cage({slot, scene_.node(node_), node_, nullptr, matrices, static_cast<int>(places.size()) - 1},
                              levels, {topologies_.get(slot), nullptr, arena, counters})
            .finest_level();
    }

private:
    Scene scene_;
    CageId cage_;
    NodeId node_;
    lod::TopologyCache topologies_;
};

TEST(RoundedBoxes, TellTheFinestLevelWhereACageIsFarFromTheirOrigin)
{
    FinestLevel finest;
    const Vec3d here(0), far{1e5, 0, 0}, farther{-1e6, 0, 0};
    const int exact = finest.at({here}, {}),
              of_far = -6;  // floats at 10^5 have steps of 2^-7, and up to twice that is asked
    EXPECT_EQ(finest.at({far}, {}), exact);
    EXPECT_EQ(finest.at({here}, here), exact);
    EXPECT_EQ(finest.at({far}, far), exact);
    EXPECT_EQ(finest.at({{40, 0, 0}}, here), exact) << "at ordinary distances";
    EXPECT_EQ(finest.at({far}, here), of_far);
    // One segment is enough in which boxes tell more.
    EXPECT_EQ(finest.at({here, far}, here), of_far);
    EXPECT_EQ(finest.at({farther, here, far, farther, farther}, here), of_far);
    EXPECT_EQ(finest.at({here, here, far, farther, farther}, here), finest.at({here, here, far, farther, farther}, {}));
}

}  // namespace
}  // namespace occam::test
