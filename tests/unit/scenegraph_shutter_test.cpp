// Tests of what a scene records while its shutter is open, and of the bounds that hold it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "base/error.h"
#include "scenegraph/content_rules.h"
#include "scenegraph/scene.h"
#include "tests/support/bent_strip.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace test;

constexpr double kPi = 3.14159265358979323846;

bool holds(const Box3d& box, Vec3d p)
{
    const Vec3d slack(1e-9);
    return glm::all(glm::greaterThanEqual(p, box.lo - slack)) && glm::all(glm::lessThanEqual(p, box.hi + slack));
}

template <class T>
T mixed(const T& a, const T& b, double s)
{
    return a * (1 - s) + b * s;
}

TEST(Shutter, KeysAreThePosesAtEvenlySpacedMoments)
{
    Scene scene;
    const NodeId mover = scene.add_node(scene.root(), {.name = "mover"});
    const NodeId still = scene.add_node(scene.root(), {.name = "still"});
    EXPECT_EQ(scene.shutter_segments(), 0);
    std::vector<double> asked;
    scene.record_shutter(4, [&](double tau) {
        asked.push_back(tau);
        scene.set_transform(mover, moved(tau, 0, 0));
        scene.set_transform(still, moved(0, 3, 0));
    });
    EXPECT_EQ(asked, (std::vector<double>{0, 0.25, 0.5, 0.75, 1, 0.5}));
    EXPECT_EQ(scene.shutter_segments(), 4);
    ASSERT_EQ(scene.node(mover).keys.size(), 5u);
    for (std::size_t k = 0; k <= 4; ++k) EXPECT_EQ(scene.node(mover).keys[k].parent_from_node, moved(double(k) / 4, 0, 0));
    EXPECT_EQ(scene.node(mover).parent_from_node, moved(0.5, 0, 0)) << "the scene is left as it is at mid-shutter";
    EXPECT_TRUE(scene.node(still).keys.empty()) << "what is posed alike at all keys does not move";
    EXPECT_EQ(scene.node(still).parent_from_node, moved(0, 3, 0));
}

TEST(Shutter, AShutterInWhichNothingMovesHasNoSegments)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    scene.record_shutter(8, [&](double) { scene.set_transform(node, moved(1, 2, 3)); });
    EXPECT_EQ(scene.shutter_segments(), 0);
    scene.record_shutter(8, [](double) {});
    EXPECT_EQ(scene.shutter_segments(), 0);
}

// A node that only a later key moves stood still at the keys before.
TEST(Shutter, WhatIsTouchedLateHasItsEarlierValuesAtEarlierKeys)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId late = scene.add_node(scene.root(), {.matrix = moved(7, 0, 0), .morph_weights = {0.25f}});
    const NodeId blinks = scene.add_node(scene.root(), {});
    const CageId cloth = scene.add(unit_square());
    std::vector<Vec3f> lifted = scene.cage(cloth).cage.positions;
    for (Vec3f& p : lifted) p.z = 2;
    int key = 0;
    scene.record_shutter(4, [&](double) {
        if (key == 3) {
            scene.set_transform(late, moved(9, 0, 0));
            scene.set_morph_weights(late, {0.75f});
            scene.set_visible(blinks, false);
            scene.write_vertices(cloth, lifted);
            scene.set_transform(bent.tip_joint, moved(2, 5, 0));
        }
        ++key;
    });
    const auto& keys = scene.node(late).keys;
    ASSERT_EQ(keys.size(), 5u);
    const auto& poses = scene.find(bent.skin)->key_poses;
    ASSERT_EQ(poses.size(), 5u);
    const auto& vertices = scene.cage(cloth).key_positions;
    ASSERT_EQ(vertices.size(), 5u);
    for (std::size_t k = 0; k <= 4; ++k) {
        EXPECT_EQ(keys[k].parent_from_node, moved(k < 3 ? 7 : 9, 0, 0)) << k;
        EXPECT_EQ(keys[k].morph_weights, std::vector<float>{k < 3 ? 0.25f : 0.75f}) << k;
        EXPECT_EQ(scene.node(blinks).keys[k].visible, k < 3) << k;
        EXPECT_EQ(vertices[k][0].z, k < 3 ? 0 : 2) << k;
        EXPECT_EQ(poses[k][1], moved(0, k < 3 ? 0 : 5, 0)) << k;
    }
    EXPECT_TRUE(scene.node(bent.skinned).keys.empty()) << "its joints move, not the node";
}

// Points of every cage, taken through matrices that are interpolated as elements, stay in the bounds.
TEST(Shutter, BoundsHoldEverythingAtEveryMoment)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId outer = scene.add_node(scene.root(), {});
    const NodeId inner = scene.add_node(outer, {.cages = {square}});
    const NodeId shows = scene.add_node(scene.root(), {.matrix = moved(0, 0, 9), .instance_of = outer});
    constexpr int kSegments = 2;
    scene.record_shutter(kSegments, [&](double tau) {
        scene.set_transform(outer, moved(3 * tau, 0, 0) * turned(2.5 * tau));
        scene.set_transform(inner, turned(-4 * tau) * moved(0, 2 + tau, 0));
        scene.set_transform(shows, moved(0, 0, 9 - 4 * tau));
    });
    const Box3d bounds = scene.bounds();
    ASSERT_EQ(scene.world_from_node_keys(inner).size(), std::size_t(kSegments) + 1);
    for (int step = 0; step <= 40; ++step) {
        const double x = step / 40.0 * kSegments;
        const auto k = std::min(std::size_t(x), std::size_t(kSegments) - 1);
        const double s = x - double(k);
        for (const Vec3f p : scene.cage(square).cage.positions) {
            const auto keys = scene.world_from_node_keys(inner);
            EXPECT_TRUE(holds(bounds, transform_point(mixed(keys[k], keys[k + 1], s), Vec3d(p)))) << step;
            // The instance leaves out the transform of the node that it shows.
            const auto instance = [&](std::size_t key) {
                return scene.node(shows).keys[key].parent_from_node * scene.node(inner).keys[key].parent_from_node;
            };
            EXPECT_TRUE(holds(bounds, transform_point(mixed(instance(k), instance(k + 1), s), Vec3d(p)))) << step;
        }
    }
}

TEST(Shutter, BoundsOfASkinnedCageHoldItsPosesAtAllKeys)
{
    Bent bent;
    Scene& scene = bent.scene;
    scene.refit();
    const Box3d before = scene.node(bent.skinned).bounds;
    scene.record_shutter(4,
                         [&](double tau) { scene.set_transform(bent.tip_joint, moved(2, 0, 0) * turned(kPi / 2 * tau)); });
    scene.refit();
    const Node& node = scene.node(bent.skinned);
    const SkinSlot& skin = *scene.find(bent.skin);
    ASSERT_EQ(skin.key_poses.size(), 5u);
    const Cage& cage = scene.cage(bent.cage).cage;
    for (std::size_t k = 0; k <= 4; ++k)
        for (std::size_t v = 0; v < cage.positions.size(); ++v) {
            Vec3d p(0);
            for (int j = 0; j < 2; ++j)
                p += double(cage.skin.weights[v][j]) *
                     transform_point(node.node_from_skin * skin.key_poses[k][std::size_t(j)], Vec3d(cage.positions[v]));
            EXPECT_TRUE(holds(node.bounds, p)) << "key " << k << ", vertex " << v;
            EXPECT_TRUE(holds(cage_bounds(node, scene.cage(bent.cage), &skin, k), p)) << "key " << k << ", vertex " << v;
        }
    EXPECT_GT(node.bounds.hi.y, before.hi.y + 0.5);
    scene.clear_shutter();
    scene.set_transform(bent.tip_joint, moved(2, 0, 0));
    scene.refit();
    EXPECT_EQ(scene.node(bent.skinned).bounds.hi.y, before.hi.y) << "bounds shrink again";
}

// A node between a skinned node and its skin's base moves the skinned node against its joints.
TEST(Shutter, ASkinnedNodeHasKeysIfWhatIsBetweenItAndItsJointsMoves)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId between = scene.add_node(scene.root(), {});
    const NodeId below = scene.add_node(between, {.cages = {bent.cage}, .skin = bent.skin});
    scene.record_shutter(2, [&](double tau) { scene.set_transform(between, moved(tau, 0, 0)); });
    const auto& keys = scene.node(below).keys;
    ASSERT_EQ(keys.size(), 3u);
    for (std::size_t k = 0; k <= 2; ++k) EXPECT_EQ(keys[k].node_from_skin, moved(-double(k) / 2, 0, 0)) << k;
    EXPECT_TRUE(scene.find(bent.skin)->key_poses.empty());
    // The joints stand still in the world, and so do the bounds.
    const Box3d moving = scene.bounds();
    scene.clear_shutter();
    const Box3d still = scene.bounds();
    EXPECT_GE(moving.hi.x, still.hi.x);
    EXPECT_LE(moving.hi.x, still.hi.x + 1) << "the box of a box may grow by what the node moves";
}

TEST(Shutter, MorphWeightsAreKeysAndGrowTheBounds)
{
    Scene scene;
    Cage cage = unit_square();
    cage.morph_targets = {{"up", std::vector<Vec3f>(4, Vec3f(0, 0, 1)), {}}};
    const CageId id = scene.add(cage);
    const NodeId node = scene.add_node(scene.root(), {.cages = {id}});
    scene.record_shutter(2, [&](double tau) { scene.set_morph_weights(node, {float(4 * tau * (1 - tau) * 3)}); });
    scene.refit();
    ASSERT_EQ(scene.node(node).keys.size(), 3u);
    EXPECT_EQ(scene.node(node).keys[1].morph_weights, std::vector<float>{3});
    EXPECT_NEAR(scene.bounds().hi.z, 3, 1e-6);
}

TEST(Shutter, AVisibilitySwitchIsHonouredFromItsKeyOn)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId node = scene.add_node(scene.root(), {.matrix = moved(5, 0, 0), .cages = {square}});
    const NodeId never = scene.add_node(scene.root(), {.matrix = moved(50, 0, 0), .cages = {square}});
    scene.record_shutter(4, [&](double tau) {
        scene.set_visible(node, tau < 0.2);
        scene.set_visible(never, tau == 1);
    });
    EXPECT_FALSE(scene.node(node).visible) << "at mid-shutter";
    EXPECT_TRUE(scene.node(node).is_visible_in_shutter());
    EXPECT_FALSE(scene.node(never).is_visible_in_shutter()) << "nothing is seen at the moment at which the shutter closes";
    EXPECT_TRUE(holds(scene.bounds(), {6, 1, 0}));
    int visits = 0;
    scene.for_each_placement([&](NodeId id, const Node&, const Mat4d&) {
        visits += id == node;
        EXPECT_NE(id, never);
    });
    EXPECT_EQ(visits, 1);
}

TEST(Shutter, VerticesThatAreWrittenAreKeysOfTheCage)
{
    Scene scene;
    const CageId id = scene.add(unit_square());
    scene.add_node(scene.root(), {.cages = {id}});
    const std::vector<Vec3f> rest = scene.cage(id).cage.positions;
    const auto lifted = [&](double height) {
        std::vector<Vec3f> positions = rest;
        positions[2].z = float(height);
        return positions;
    };
    scene.record_shutter(2, [&](double tau) { scene.write_vertices(id, lifted(tau)); });
    EXPECT_EQ(scene.shutter_segments(), 2);
    ASSERT_EQ(scene.cage(id).key_positions.size(), 3u);
    EXPECT_EQ(scene.cage(id).key_positions[2][2].z, 1);
    EXPECT_EQ(scene.cage(id).cage.positions[2].z, 0.5f);
    EXPECT_EQ(scene.bounds().hi.z, 1);
    scene.write_vertices(id, rest);
    EXPECT_EQ(scene.shutter_segments(), 0);
    EXPECT_EQ(scene.bounds().hi.z, 0);
}

TEST(Shutter, AnEditDropsTheKeysOfWhatItEditsAndOfNothingElse)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId a = scene.add_node(scene.root(), {}), b = scene.add_node(scene.root(), {});
    const auto record = [&] {
        scene.record_shutter(2, [&](double tau) {
            scene.set_transform(a, moved(tau, 0, 0));
            scene.set_transform(b, moved(0, tau, 0));
            scene.set_transform(bent.tip_joint, moved(2, tau, 0));
        });
        scene.refit();
    };
    record();
    scene.set_transform(a, moved(0.5, 0, 0));
    EXPECT_TRUE(scene.node(a).keys.empty()) << "also where the edit leaves the value as it is";
    EXPECT_FALSE(scene.node(b).keys.empty());
    EXPECT_FALSE(scene.find(bent.skin)->key_poses.empty());
    scene.set_transform(bent.root_joint, moved(0, 0, 1));
    scene.refit();
    EXPECT_FALSE(scene.find(bent.skin)->key_poses.empty()) << "its other joint still moves";
    EXPECT_FALSE(scene.node(bent.tip_joint).keys.empty());
    scene.set_transform(bent.tip_joint, moved(2, 0, 0));
    scene.refit();
    EXPECT_TRUE(scene.find(bent.skin)->key_poses.empty()) << "none of its joints moves";
    EXPECT_EQ(scene.shutter_segments(), 2);

    record();
    scene.set_visible(b, false);
    scene.remove(a);
    scene.remove(bent.skin);
    scene.set_transform(bent.tip_joint, Mat4d(1));
    EXPECT_EQ(scene.shutter_segments(), 0) << "nothing is left that moves";

    scene.clear_shutter();
    EXPECT_EQ(scene.shutter_segments(), 0);
}

TEST(Shutter, ClipsAndCopiesAreRecordedAndANewPoseDropsTheirKeys)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId subtree = scene.add_node(scene.root(), {.name = "subtree"});
    const NodeId part = scene.add_node(subtree, {.name = "part", .cages = {square}});
    Channel slide;
    slide.target = part;
    slide.times = {0, 1};
    slide.values = {0, 0, 0, 10, 0, 0};
    const ClipId clip = scene.add(Clip{"slide", {slide}});
    const NodeId copy = scene.copy(subtree, scene.root());
    const NodeId copied_part = scene.node(copy).children.at(0);
    scene.record_shutter(2, [&](double tau) {
        const ClipAt at[] = {{clip, tau}}, later[] = {{clip, 0.5 + tau / 4}};
        scene.pose(at);
        scene.pose(later, copy);
    });
    ASSERT_EQ(scene.node(part).keys.size(), 3u);
    ASSERT_EQ(scene.node(copied_part).keys.size(), 3u);
    EXPECT_EQ(scene.node(part).keys[2].parent_from_node, moved(10, 0, 0));
    EXPECT_EQ(scene.node(copied_part).keys[2].parent_from_node, moved(7.5, 0, 0));
    EXPECT_TRUE(holds(scene.bounds(), {11, 1, 0}));

    const NodeId another = scene.copy(subtree, scene.root());
    EXPECT_TRUE(scene.node(scene.node(another).children.at(0)).keys.empty()) << "a copy starts at rest";

    const ClipAt middle[] = {{clip, 0.5}};
    scene.pose(middle);
    EXPECT_TRUE(scene.node(part).keys.empty()) << "also where the pose is the one that it has";
    EXPECT_FALSE(scene.node(copied_part).keys.empty());
    scene.pose(std::span<const ClipAt>(), copy);
    EXPECT_EQ(scene.shutter_segments(), 0);
}

TEST(Shutter, BoundsUnderManyChildrenFollowKeysThatComeAndGo)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    std::vector<NodeId> nodes;
    for (int i = 0; i < 200; ++i) nodes.push_back(scene.add_node(scene.root(), {.cages = {square}}));
    scene.refit();
    scene.record_shutter(1, [&](double tau) { scene.set_transform(nodes[77], moved(40 * (tau - 0.5), 0, 0)); });
    EXPECT_EQ(scene.bounds().hi.x, 21);
    EXPECT_EQ(scene.bounds().lo.x, -20);
    scene.clear_shutter();
    EXPECT_EQ(scene.bounds().hi.x, 1);
}

TEST(Shutter, KeysThatTakeTooMuchMemoryAreRefusedAndNoneAreLeft)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    const auto blend = [&](std::size_t weights) {
        return [&scene, node, weights](double tau) {
            scene.set_morph_weights(node, std::vector<float>(weights, static_cast<float>(tau)));
        };
    };
    EXPECT_THROW(scene.record_shutter(32, blend(std::size_t(9) << 20)), Error);
    EXPECT_EQ(scene.shutter_segments(), 0);
    EXPECT_TRUE(scene.node(node).keys.empty());
    scene.record_shutter(32, blend(9));
    EXPECT_EQ(scene.shutter_segments(), 32);
}

TEST(Shutter, ACameraThatMovesHasKeys)
{
    Scene scene;
    const CameraId lens = scene.add(CameraLens{});
    const NodeId dolly = scene.add_node(scene.root(), {});
    scene.add_node(dolly, {.name = "moving", .matrix = moved(0, 1, 0), .camera = lens});
    scene.add_node(scene.root(), {.name = "still", .camera = lens});
    scene.record_shutter(2, [&](double tau) { scene.set_transform(dolly, moved(tau, 0, 0)); });
    const Camera camera = scene.camera("moving").value();
    ASSERT_EQ(camera.keys.size(), 3u);
    for (std::size_t k = 0; k <= 2; ++k) EXPECT_EQ(Vec3d(camera.keys[k][3]), Vec3d(double(k) / 2, 1, 0));
    EXPECT_EQ(camera.eye(), Vec3d(0.5, 1, 0));
    EXPECT_TRUE(scene.camera("still").value().keys.empty());
}

}  // namespace
}  // namespace occam
