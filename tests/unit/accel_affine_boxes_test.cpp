// Tests of the boxes of cages that their nodes alone move: they hold what rays meet that were taken to the still pose and
// rounded there (accel/affine_ray.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "accel/affine_ray.h"
#include "accel/items.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns by how much a ray is elsewhere in the world than its rounded image in the still pose, where it is next to a point
/// of that pose.
Vec3d offset_near(Vec3d still, const accel::Ray& ray, const lod::PosedCage& cage)
{
    const accel::AffineRay rounded(ray, cage);
    const Vec3d from(rounded.origin[0], rounded.origin[1], rounded.origin[2]);
    const Vec3d along(rounded.direction[0], rounded.direction[1], rounded.direction[2]);
    const double t = glm::dot(still - from, along) / glm::dot(along, along);
    const Vec3d image = rounded.pose.anchor + rounded.pose.apply(from + along * t);
    return ray.origin + Vec3d(ray.direction) * (t + double(rounded.shift)) - image;
}

/// Aims rays from all sides at the corners of an igrid's bounds in the still pose. Returns how many would pass beside the
/// igrid's box in the world, though they pass through those bounds.
int count_outside(const accel::Items& items, const accel::IGrid& grid, Vec3d anchor, Random& random)
{
    int outside = 0;
    const Box3f bounds = grid.bounds();
    for (const float time : {0.0f, 0.3f, 1.0f}) {
        const lod::AffinePose pose = grid.cage->affine->at(time);
        const Box3f box = items.box_at(grid, time);
        for (int k = 0; k < 64; ++k) {
            const Vec3d corner(k & 1 ? bounds.hi.x : bounds.lo.x, k & 2 ? bounds.hi.y : bounds.lo.y,
                               k & 4 ? bounds.hi.z : bounds.lo.z);
            const Vec3d image = pose.anchor + pose.apply(corner), way = random.direction();
            accel::Ray ray;
            ray.origin = image - way * (double(grid.cage->radius) * (1 + k % 3));
            ray.direction = Vec3f(way);
            ray.time = time;
            const Vec3d met = image + offset_near(corner, ray, *grid.cage) - anchor;
            for (int a = 0; a < 3; ++a) outside += met[a] < double(box.lo[a]) || met[a] > double(box.hi[a]);
        }
    }
    return outside;
}

TEST(AffineBoxes, HoldWhatRoundedRaysMeet)
{
    Motion motion{"turns and flies", 2, {}, {}, {}, {}};
    motion.matrix = [](double tau) {
        Mat4d m = moved_by(Vec3d(1, 2, -1) * tau);
        m[0] = Vec4d(std::cos(tau), 0.3 * tau, -std::sin(tau), 0);
        m[2] = Vec4d(std::sin(tau), 0, std::cos(tau), 0);
        return m;
    };
    Scene scene;
    add_moving(scene, torus(), motion);
    scene.refit();
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, {.pixel = {1.0f / 16, 0}, .mode = lod::LevelMode::PerRay, .motion_edges = 0},
                             {});
    Arena arena;
    lod::Dicer dicer;
    accel::TraceCounters counters;
    accel::Items items(frame.state(), arena, dicer, counters, true);
    items.restart();
    Random random(3);
    int grids = 0, outside = 0;
    for (const accel::ItemIndex i : items.base_patches()) {
        const int pair = std::max<int>(items[i].final_from, lod::kFinestLevel);
        if (!items.is_final(i, pair)) continue;
        const accel::IGrid& grid = items.grid(i, pair);
        ASSERT_TRUE(grid.cage->affine) << "the cage is diced in one pose";
        outside += count_outside(items, grid, frame.state().anchor, random);
        ++grids;
    }
    EXPECT_GT(grids, 20);
    EXPECT_EQ(outside, 0);
}

}  // namespace
}  // namespace occam::test
