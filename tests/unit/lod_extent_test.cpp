// Tests of the points by which a scene is framed (lod/extent.h).
#include <gtest/gtest.h>

#include "lod/extent.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

std::size_t points_of(lod::Extent& extent, const Scene& scene)
{
    std::size_t points = 0;
    extent.visit_points(scene, [&](Vec3d) { ++points; });
    return points;
}

// Thousands of cages took gigabytes when each of them was refined.
TEST(Extent, RefinesAsManyCagesAsFitAndThoseThatChangeAgain)
{
    constexpr std::size_t kVertices = 40 * 20, kRefined = kVertices * 64;  // a torus of quads has as many faces as vertices
    Scene scene;
    std::vector<CageId> cages;
    for (int k = 0; k < 60; ++k) {
        cages.push_back(scene.add(torus(40, 20)));
        place(scene, cages.back(), {double(k), 0, 0});
    }
    scene.refit();
    lod::Extent extent;
    const std::size_t points = points_of(extent, scene), refined = (points - 60 * kVertices) / (kRefined - kVertices);
    EXPECT_EQ(points, refined * kRefined + (60 - refined) * kVertices) << "each cage is refined, or gives its vertices";
    EXPECT_GE(refined, 30u);
    EXPECT_LT(refined, 45u);

    // The same ones are refined in each frame of an animation.
    for (int frame = 0; frame < 4; ++frame) {
        for (const CageId id : cages) {
            std::vector<Vec3f> moved = scene.find(id)->cage.positions;
            for (Vec3f& p : moved) p *= 1.5f;
            scene.write_vertices(id, moved);
        }
        scene.refit();
        EXPECT_EQ(points_of(extent, scene), points) << "frame " << frame;
    }
}

TEST(Extent, HoldsNothingThatAGroupHidesFromTheCamera)
{
    Scene scene;
    const CageId cube = scene.add(creased_cube(1));
    place(scene, cube, {0, 0, 0});
    scene.refit();
    lod::Extent extent;
    const std::size_t alone = points_of(extent, scene);
    NodeDesc hidden{.seen_by = RayKind::Shadow};
    const NodeId group = scene.add_node(scene.root(), hidden);
    const NodeId below = scene.add_node(group, {.cages = {cube}});
    scene.add_node(group, {.instance_of = below});
    scene.refit();
    EXPECT_EQ(points_of(extent, scene), alone);
}

// Where many refined cages lie side by side, further ones give the eight corners of their boxes.
TEST(Extent, CountsThePointsThatItVisits)
{
    Scene scene;
    const CageId torus_of_quads = scene.add(torus(40, 20));
    constexpr int kSide = 40;
    for (int k = 0; k < kSide * kSide; ++k) place(scene, torus_of_quads, {double(k % kSide), double(k / kSide), 0});
    scene.refit();
    lod::Extent extent;
    EXPECT_LT(points_of(extent, scene), 51'000'000u) << "some 80 million points if all were refined";
}

}  // namespace
}  // namespace occam::test
