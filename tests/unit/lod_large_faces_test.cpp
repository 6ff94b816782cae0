// Tests of faces with very many corners.
#include <gtest/gtest.h>

#include "lod/extent.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

TEST(LargeFaces, HaveOneClassForAllPartsThatAreAlike)
{
    constexpr std::uint32_t kCorners = 130;
    const DicedCage diced(prism(kCorners), 0);
    const lod::Topology& topology = diced.topology();
    const auto kind = [&](std::uint32_t face, std::uint32_t sub) { return topology.controls({face, sub}).kind; };
    for (std::uint32_t sub = 0; sub < kCorners; ++sub) {
        EXPECT_EQ(kind(0, sub), kind(0, 0)) << "part " << sub << " of the lower face, which has no creases";
        EXPECT_EQ(kind(1, sub), kind(1, sub % 2)) << "part " << sub << " of the upper face, with two kinds in turn";
    }
}

TEST(LargeFaces, AreAsRoundAsTheirCage)
{
    constexpr std::uint32_t kCorners = 130;
    const DicedCage diced(prism(kCorners), 0);
    lod::PosedPatch patch;
    patch.set(diced.posed, {0, 0});
    const Vec3f first = patch.point(0.3f, 0.6f), middle = patch.point(1, 1);
    for (const std::uint32_t sub : {1u, 37u, 64u, 129u}) {
        patch.set(diced.posed, {0, sub});
        EXPECT_LT(glm::distance(patch.point(1, 1), middle), 1e-5f);
        // The lower face's corners run the other way round.
        const double turn = -6.283185307 * sub / kCorners, c = std::cos(turn), s = std::sin(turn);
        const Vec3d at(patch.point(0.3f, 0.6f));
        const Vec3d back{c * at.x + s * at.z, at.y, c * at.z - s * at.x};
        const Vec3d forth{c * at.x - s * at.z, at.y, c * at.z + s * at.x};
        EXPECT_LT(std::min(glm::distance(back, Vec3d(first)), glm::distance(forth, Vec3d(first))), 1e-5) << "part " << sub;
    }
}

// All faces of such a cage share one of its two poles, so no face is left.
TEST(LargePoles, LeaveACageThatHasNoExtent)
{
    Scene scene;
    place(scene, scene.add(spindle(600)), {0, 0, 0});
    scene.refit();
    int points = 0;
    lod::Extent().visit_points(scene, [&](Vec3d) { ++points; });
    EXPECT_EQ(points, 0);
}

}  // namespace
}  // namespace occam::test
