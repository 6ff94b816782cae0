// Tests of how much memory igrids that move take: their boxes and normals at keys are stored in short.
#include <gtest/gtest.h>

#include <cmath>

#include "accel/box_tree.h"
#include "accel/frame.h"
#include "accel/tracer.h"
#include "lod/short_normal.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

// Returns the bytes that are built for many rays at all times towards a torus, whose vertices are written at each key.
std::size_t bytes_of_written_torus(int segments)
{
    Scene scene;
    const Cage ring = torus(12, 8);
    const CageId cage = scene.add(ring);
    NodeDesc desc;
    desc.cages = {cage};
    scene.add_node(scene.root(), std::move(desc));
    const auto pose = [&](double tau) {
        const double sine = std::sin(1.5 * tau), cosine = std::cos(1.5 * tau);
        std::vector<Vec3f> moved;
        for (const Vec3f p : ring.positions)
            moved.push_back(Vec3f(p.x, cosine * p.y - sine * p.z + 0.1 * tau * p.x * p.x, sine * p.y + cosine * p.z));
        scene.write_vertices(cage, moved);
    };
    if (segments > 0) scene.record_shutter(segments, pose);
    else pose(0);
    scene.refit();
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies,
                             {.pixel = {0.125f, 0}, .mode = lod::LevelMode::PerInstance, .motion_edges = 0});
    Random random(7);
    std::vector<accel::Ray> rays(20'000);
    for (accel::Ray& ray : rays) {
        ray.direction = Vec3f(random.direction());
        ray.origin = scene.bounds().centre() + random.direction() - 9.0 * Vec3d(ray.direction);
        ray.time = static_cast<float>(random());
    }
    std::vector<accel::SurfaceHit> hits(rays.size());
    accel::Tracer tracer(frame, std::size_t(1) << 30);
    tracer.closest(rays, hits);
    EXPECT_GT(tracer.counters().grids, 60u);
    return tracer.counters().peak_bytes;
}

TEST(MovingIGrids, TakesAsMuchMemoryAsTheFiguresSay)
{
    const auto still = static_cast<double>(bytes_of_written_torus(0));
    EXPECT_LT(static_cast<double>(bytes_of_written_torus(1)) / still, 1.15);
    EXPECT_LT(static_cast<double>(bytes_of_written_torus(8)) / still, 3.3);
}

// Returns whether a box holds another one.
bool holds(const Box3f& box, const Box3f& other)
{
    return glm::all(glm::lessThanEqual(box.lo, other.lo)) && glm::all(glm::greaterThanEqual(box.hi, other.hi));
}

TEST(BoxTree, OfAnyNumberOfLeavesHoldsThemAtEachKey)
{
    constexpr int kKeys = 3;
    Random random(9);
    for (const int leaves : {1, 2, 3, 4, 7, 8, 9, 16, 17, 33, 100}) {
        std::vector<Box3f> boxes;
        for (int k = 0; k < leaves * kKeys; ++k) {
            const Vec3f lo(random(), random(), random());
            boxes.push_back({lo, lo + 0.1f});
        }
        Arena arena;
        const auto box_at = [&](int leaf, int key) { return boxes[std::size_t(leaf * kKeys + key)]; };
        const accel::BoxTree moving = accel::make_moving_box_tree(leaves, kKeys, arena, box_at),
                             still = accel::make_still_box_tree(leaves, arena, [&](int leaf) { return box_at(leaf, 0); });
        EXPECT_EQ(moving.leaves, still.leaves);
        EXPECT_LE(4 * moving.floats_of_a_key, 3 * still.floats_of_a_key) << leaves;
        for (int key = 0; key < kKeys; ++key) {
            const accel::BoxTree tree = moving.at_key(key);
            for (int leaf = 0; leaf < leaves; ++leaf) {
                const Box3f box = accel::BoxTree::box(tree.leaf(leaf), tree.row);
                ASSERT_TRUE(holds(box, box_at(leaf, key)) && holds(tree.bounds(), box)) << leaves;
                if (!tree.has_fourth_row()) continue;
                const float* above = tree.fourth_row() + leaf / (tree.leaves / accel::BoxTree::kGroup);
                ASSERT_TRUE(holds(accel::BoxTree::box(above, accel::BoxTree::kGroup), box)) << leaves;
            }
        }
    }
}

TEST(ShortNormal, TurnsUnitVectorsByLittleAndAxesNotAtAll)
{
    Random random(13);
    for (int k = 0; k < 1000; ++k) {
        const Vec3d n = random.direction(), kept = lod::ShortNormal(Vec3f(n)).get();
        EXPECT_LT(glm::length(glm::cross(n, kept)), 2.8e-5);  // 0.0016 degrees
        EXPECT_NEAR(glm::length(kept), 1, 2.8e-5);
    }
    for (const Vec3f n : {Vec3f(1, 0, 0), Vec3f(0, -1, 0), Vec3f(0)}) EXPECT_EQ(lod::ShortNormal(n).get(), n);
    EXPECT_EQ(lod::ShortNormal(Vec3f(2, -2, NAN)).get(), Vec3f(1, -1, -1));
}

}  // namespace
}  // namespace occam::test
