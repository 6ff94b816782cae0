// Tests of which tables of cages are kept from frame to frame.
#include "lod/topology_cache.h"

#include <gtest/gtest.h>

#include "tests/support/shape_builders.h"

namespace occam {
namespace {

TEST(TopologyCache, ForgetsCagesThatAreRemovedOrReplacedAndNoOthers)
{
    // Squares with corners of other sharpness have topologies of their own.
    const auto square = [](float sharpness) {
        Cage cage = test::unit_square();
        cage.corners = {{0, sharpness}};
        return cage;
    };
    Scene scene, other;
    const CageId removed = scene.add(square(1)), replaced = scene.add(square(2)), kept = scene.add(square(3));
    const CageId foreign = other.add(square(4));
    lod::TopologyCache cache;
    const Scene* const scenes[] = {&scene};
    const auto topology_of = [&](const Scene& of, CageId id) {
        return std::weak_ptr<const lod::Topology>(cache.get(of.cage(id)).topology);
    };
    const auto of_removed = topology_of(scene, removed), of_replaced = topology_of(scene, replaced);
    const auto of_kept = topology_of(scene, kept), of_foreign = topology_of(other, foreign);

    cache.prune(scenes);
    EXPECT_TRUE(of_foreign.expired());
    EXPECT_FALSE(of_removed.expired() || of_replaced.expired());
    scene.remove(removed);
    scene.replace(replaced, square(5));
    std::vector<Vec3f> positions = test::unit_square().positions;
    positions[0].z = 1;
    scene.write_vertices(kept, positions);
    cache.prune(scenes);
    EXPECT_TRUE(of_removed.expired());
    EXPECT_TRUE(of_replaced.expired());
    EXPECT_FALSE(of_kept.expired());
}

}  // namespace
}  // namespace occam
