// Tests of the sums of morph targets: a frame with too many is refused, and blocks of vertices have the sums of single ones.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/arena.h"
#include "base/error.h"
#include "lod/deformed_cage.h"
#include "scenegraph/contents.h"
#include "scenegraph/scene.h"
#include "tests/support/bent_strip.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Cage morphed_cage(std::size_t targets)
{
    Cage cage = torus();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> offset(-1, 1);
    for (std::size_t k = 0; k < targets; ++k) {
        MorphTarget target;
        if (k % 3 != 2)
            for (std::size_t v = 0; v < cage.positions.size(); ++v)
                target.positions.emplace_back(offset(random), offset(random), offset(random));
        cage.morph_targets.push_back(std::move(target));
        cage.morph_weights.push_back(k % 4 == 1 ? 0 : offset(random));
    }
    return cage;
}

TEST(MorphOffsets, ABlockOfVerticesHasTheSumsOfEach)
{
    Scene scene;
    const CageId id = scene.add(morphed_cage(25));
    NodeDesc desc;
    desc.cages = {id};
    const NodeId node = scene.add_node(scene.root(), desc);
    const CageSlot& slot = scene.cage(id);
    const double rows[3][4] = {{1, 0, 0, 0.1}, {0, 1, 0, 0.2}, {0, 0, 1, 0.3}};
    Arena arena;
    lod::DeformCounters counters;
    lod::DeformedCage cage(slot, lod::CagePose(slot, scene.node(node), nullptr), rows, arena, counters);
    for (std::uint32_t v = 0; v < slot.cage.positions.size(); ++v) EXPECT_EQ(cage.position(v), cage.posed(v)) << v;
}

TEST(MorphOffsets, AreCountedWithInstancesAndRefusedBeyondTheirLimit)
{
    Scene scene;
    const CageId id = scene.add(morphed_cage(12));  // 9 of them have a weight, of which 6 have positions
    NodeDesc desc;
    desc.cages = {id};
    NodeId shown = scene.add_node(scene.root(), desc);
    scene.refit();
    const double once = scene.contents().pose_terms;
    EXPECT_EQ(once, 6.0 * double(scene.cage(id).cage.positions.size()));
    double copies = 1;
    for (; copies * once <= kMostPoseTerms; copies *= 4) {
        NodeDesc group;
        group.name = "crowd";
        const NodeId of = scene.add_node(scene.root(), group);
        for (int i = 0; i < 4; ++i) {
            NodeDesc instance;
            instance.instance_of = shown;
            instance.place.translation = Vec3d(i % 2, i / 2, 0) * std::sqrt(copies) * 4.0;
            scene.add_node(of, instance);
        }
        shown = of;
    }
    scene.refit();
    try {
        check_layers(scene);
        ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("offsets and shares of joints, and 1.72e+10 is the limit (node 'crowd')"), std::string::npos)
            << text;
    }
}

// A node that is moved adds up no more offsets than one that hangs below a node which is moved.
TEST(MorphOffsets, CountForEachKeyOnlyWhereTheWeightsChange)
{
    Scene scene;
    NodeDesc desc;
    desc.cages = {scene.add(morphed_cage(12))};
    desc.morph_weights.assign(12, 1);
    const NodeId above = scene.add_node(scene.root(), {}), node = scene.add_node(above, desc);
    const auto offsets = [&] {
        scene.refit();
        return scene.contents().pose_terms;
    };
    const double once = offsets();
    EXPECT_GT(once, 0);
    for (const NodeId moved : {above, node}) {
        scene.record_shutter(8, [&](double tau) { scene.set_transform(moved, Trs{.translation = {tau, 0, 0}}); });
        EXPECT_EQ(offsets(), once);
    }
    scene.record_shutter(8, [&](double tau) { scene.set_visible(node, tau <= 0.5); });
    EXPECT_EQ(offsets(), once);
    scene.record_shutter(8, [&](double tau) {
        std::vector<float> weights(12, 1);
        weights[0] = 1 + float(tau);
        scene.set_morph_weights(node, weights);
    });
    EXPECT_EQ(offsets(), 9 * once);
}

// Each vertex takes up to four joints of each set, for each pose of the skin.
TEST(MorphOffsets, SharesOfJointsCountLikewise)
{
    Bent bent;
    const auto terms = [&] {
        bent.scene.refit();
        return bent.scene.contents().pose_terms;
    };
    const double once = 4.0 * double(bent.scene.cage(bent.cage).cage.positions.size());
    EXPECT_EQ(terms(), once);
    bent.scene.add_node(bent.scene.root(), {.cages = {bent.cage}, .skin = bent.skin});
    EXPECT_EQ(terms(), 2 * once);
    bent.scene.record_shutter(4, [&](double tau) { bent.scene.set_transform(bent.tip_joint, moved(2, tau, 0)); });
    EXPECT_EQ(terms(), 5 * 2 * once);
    bent.scene.set_skin(bent.skinned, {});
    EXPECT_EQ(terms(), 5 * once);
}

}  // namespace
}  // namespace occam::test
