// Tests of edits that hang nodes elsewhere, or change what they hold.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "occam/occam.h"
#include "tests/support/bent_strip.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace test;

Mat4d value_at(const std::vector<Mat4d>& keys, const Mat4d& still, std::size_t key)
{
    return keys.empty() ? still : keys[key];
}

/// Expects of every skinned node that its skin lies where its joints are, in the middle of the shutter and at each of its
/// keys.
void expect_skins_on_their_joints(Scene& scene, const std::vector<NodeId>& wearers)
{
    scene.refit();
    for (const NodeId id : wearers) {
        const Node& node = scene.node(id);
        const SkinSlot& skin = *scene.find(node.skin);
        const std::vector<Mat4d> node_keys = scene.world_from_node_keys(id);
        for (std::size_t j = 0; j < skin.skin.joints.size(); ++j) {
            const NodeId joint = skin.skin.joints[j];
            const Mat4d expected = scene.world_from_node(joint) * skin.skin.joint_from_mesh[j];
            const Mat4d found = scene.world_from_node(id) * node.node_from_skin * skin.mesh_poses[j];
            for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(found[c] - expected[c]), 1e-6) << "joint " << j;
            const std::vector<Mat4d> joint_keys = scene.world_from_node_keys(joint);
            for (std::size_t k = 0; k < (scene.shutter_segments() > 0 ? std::size_t(scene.shutter_segments()) + 1 : 0);
                 ++k) {
                const Mat4d at_key = value_at(joint_keys, scene.world_from_node(joint), k) * skin.skin.joint_from_mesh[j];
                const Mat4d own = value_at(node_keys, scene.world_from_node(id), k) *
                                  (node.keys.empty() ? node.node_from_skin : node.keys[k].node_from_skin) *
                                  value_at(skin.key_poses.empty() ? std::vector<Mat4d>() : skin.key_poses[k],
                                           skin.mesh_poses[j], j);
                for (int c = 0; c < 4; ++c)
                    EXPECT_LT(glm::length(own[c] - at_key[c]), 1e-6) << "joint " << j << ", key " << k;
            }
        }
    }
}

TEST(SceneLinks, ANodeHangsBelowAnotherAndKeepsItsTransform)
{
    Scene scene;
    const CageId square = scene.add(unit_square());
    const NodeId ground = scene.add_node(scene.root(), {.matrix = moved(10, 0, 0)});
    const NodeId hand = scene.add_node(scene.root(), {.matrix = moved(0, 5, 0)});
    scene.add_node(hand, {});
    const NodeId sword = scene.add_node(ground, {.matrix = moved(0, 0, 2)});
    const NodeId blade = scene.add_node(sword, {.matrix = moved(1, 0, 0), .cages = {square}});
    EXPECT_EQ(scene.bounds().lo, Vec3d(11, 0, 2));
    scene.set_parent(sword, hand);
    EXPECT_EQ(scene.bounds().lo, Vec3d(1, 5, 2));
    EXPECT_EQ(scene.node(sword).parent, hand);
    EXPECT_EQ(scene.node(hand).children.back(), sword);
    EXPECT_TRUE(scene.node(ground).children.empty());
    EXPECT_EQ(scene.find_node("", hand), hand);
    scene.set_transform(hand, moved(0, 7, 0));
    EXPECT_EQ(scene.bounds().lo, Vec3d(1, 7, 2));

    const Mat4d world = scene.world_from_node(blade);
    scene.set_parent(blade, ground);
    scene.set_transform(blade, glm::inverse(scene.world_from_node(ground)) * world);
    EXPECT_EQ(scene.bounds().lo, Vec3d(1, 7, 2));
    scene.remove(hand);
    EXPECT_EQ(scene.bounds().lo, Vec3d(1, 7, 2)) << "the blade no longer hangs below what was removed";
}

TEST(SceneLinks, RefusesCirclesAndTheRoot)
{
    Scene scene;
    const NodeId a = scene.add_node(scene.root(), {}), b = scene.add_node(a, {}), c = scene.add_node(b, {});
    const NodeId other = scene.add_node(scene.root(), {});
    const NodeId shows_a = scene.add_node(other, {.instance_of = a});
    EXPECT_THROW(scene.set_parent(scene.root(), a), Error);
    EXPECT_THROW(scene.set_parent(a, a), Error);
    EXPECT_THROW(scene.set_parent(a, c), Error);
    EXPECT_THROW(scene.set_parent(other, c), Error) << "c would show itself by the instance of a";
    EXPECT_THROW(scene.set_instance_of(c, other), Error);
    EXPECT_THROW(scene.set_instance_of(c, a), Error);
    EXPECT_THROW(scene.set_parent(c, NodeId()), Error);
    EXPECT_EQ(scene.node(c).parent, b);
    scene.set_instance_of(shows_a, {});
    EXPECT_NO_THROW(scene.set_parent(other, c)) << "it no longer shows a";
    EXPECT_THROW(scene.set_instance_of(shows_a, a), Error);
    EXPECT_NO_THROW(scene.set_parent(other, scene.root()));
    EXPECT_NO_THROW(scene.set_instance_of(shows_a, c));
    {
        const Scene::FrameLock lock(scene);
        EXPECT_THROW(scene.set_parent(c, a), Error);
        EXPECT_THROW(scene.set_cages(c, {}), Error);
        EXPECT_THROW(scene.set_light(c, {}), Error);
        EXPECT_THROW(scene.set_camera(c, {}), Error);
        EXPECT_THROW(scene.set_instance_of(c, {}), Error);
    }
    EXPECT_THROW(scene.record_shutter(1, [&](double) { scene.set_parent(c, a); }), Error);
    EXPECT_NO_THROW(scene.set_parent(c, a));
}

// Anything may be moved below anything else: joints, skinned nodes, and what lies above them.
TEST(SceneLinks, SkinsFollowTheirJointsWhereverNodesAreMoved)
{
    std::mt19937 random(5);
    const auto pick = [&](std::size_t n) { return std::size_t(random() % n); };
    const auto place = [&] {
        const double x = double(pick(9)) - 4, y = double(pick(9)) - 4, angle = 0.1 * double(pick(60));
        return moved(x, y, 0) * turned(angle);
    };
    int moves = 0;
    for (int world = 0; world < 8; ++world) {
        SCOPED_TRACE("world " + std::to_string(world));
        Bent bent;
        Scene& scene = bent.scene;
        std::vector<NodeId> nodes{bent.root_joint, bent.tip_joint, bent.skinned};
        for (int i = 0; i < 6; ++i) nodes.push_back(scene.add_node(nodes[pick(nodes.size())], {.matrix = place()}));
        std::vector<NodeId> wearers{bent.skinned};
        const SkinId second = scene.add(Skin{"second", {nodes[4], nodes[5], nodes[6]}, {place(), place(), place()}});
        for (const SkinId skin : {bent.skin, second}) {
            const NodeId above = nodes[pick(nodes.size())];
            wearers.push_back(scene.add_node(above, {.cages = {bent.cage}, .skin = skin}));
            nodes.push_back(wearers.back());
        }
        for (int step = 0; step < 60; ++step) {
            SCOPED_TRACE("step " + std::to_string(step));
            const NodeId id = nodes[pick(nodes.size())], to = pick(5) == 0 ? scene.root() : nodes[pick(nodes.size())];
            if (pick(4) == 0) {
                const NodeId goes = nodes[pick(nodes.size())];
                scene.record_shutter(2, [&](double tau) { scene.set_transform(goes, moved(tau, 1, 0) * turned(tau)); });
            } else if (pick(3) == 0) {
                scene.set_transform(id, place());
            } else {
                try {
                    scene.set_parent(id, to);
                    ++moves;
                } catch (const Error&) {
                }
            }
            if (pick(2) == 0) expect_skins_on_their_joints(scene, wearers);
            if (testing::Test::HasFailure()) return;
        }
    }
    EXPECT_GT(moves, 100);
}

TEST(SceneLinks, ANodeShowsItsNewCagesAndInstance)
{
    Scene scene;
    const CageId square = scene.add(unit_square()), prism = scene.add(test::prism(5));
    const NodeId node = scene.add_node(scene.root(), {.cages = {square}});
    const NodeId instance = scene.add_node(scene.root(), {.matrix = moved(10, 0, 0), .instance_of = node});
    EXPECT_EQ(scene.bounds().hi, Vec3d(11, 1, 0));
    scene.set_cages(node, {});
    EXPECT_TRUE(scene.bounds().is_empty());
    scene.set_cages(node, {prism, square});
    Box3d both = scene.cage(prism).bounds;
    both.add(scene.cage(square).bounds);
    Box3d expected = both;
    expected.add(transform_box(moved(10, 0, 0), both));
    EXPECT_EQ(scene.bounds().lo, expected.lo);
    EXPECT_EQ(scene.bounds().hi, expected.hi);
    scene.set_instance_of(instance, {});
    EXPECT_EQ(scene.bounds().hi, both.hi);
    const NodeId other = scene.add_node(scene.root(), {.cages = {square}, .visible = false});
    scene.set_instance_of(instance, other);
    EXPECT_EQ(scene.bounds().hi.x, 11);
    scene.set_cages(node, {});
    EXPECT_EQ(scene.bounds().lo, Vec3d(10, 0, 0)) << "the instance no longer shows the node";
}

TEST(SceneLinks, LampsAndCamerasAreSwitched)
{
    Scene scene;
    const LightId lamp = scene.add(Light{"lamp", PointLight{Vec3f(9)}});
    const CameraId wide = scene.add(CameraLens{.fov = 1.2f}), narrow = scene.add(CameraLens{.fov = 0.3f});
    const NodeId node = scene.add_node(scene.root(), {.name = "node"});
    const auto lamps = [&] {
        int found = 0;
        scene.refit();
        scene.for_placements_of(Contents::Lights, [&](NodeId, const Node&, const Mat4d&) { ++found; });
        return found;
    };
    EXPECT_EQ(lamps(), 0);
    scene.set_light(node, lamp);
    EXPECT_EQ(lamps(), 1);
    scene.set_light(node, {});
    EXPECT_EQ(lamps(), 0);

    EXPECT_FALSE(scene.camera());
    scene.set_camera(node, wide);
    EXPECT_EQ(scene.camera("node").value().lens.fov, 1.2f);
    scene.set_camera(node, narrow);
    EXPECT_EQ(scene.camera_names(), std::vector<std::string>{"node"});
    EXPECT_EQ(scene.camera().value().lens.fov, 0.3f);
    scene.replace(narrow, CameraLens{.fov = 0.5f});
    EXPECT_EQ(scene.camera().value().lens.fov, 0.5f);
    EXPECT_THROW(scene.replace(narrow, CameraLens{.fov = -1}), Error);
    EXPECT_EQ(scene.camera_of(node).value().lens.fov, 0.5f);
    scene.set_camera(node, {});
    EXPECT_FALSE(scene.camera_of(node));
    EXPECT_FALSE(scene.camera());
    EXPECT_TRUE(scene.camera_names().empty());
}

// Where a skin is depends on the joints that it has now, and not on which were removed before which edit.
TEST(SceneLinks, ASkinWithoutOneOfItsJointsDoesNotDependOnHistory)
{
    struct Case {
        Bent bent;
        NodeId arm, other;
        Case()
        {
            Scene& scene = bent.scene;
            arm = scene.add_node(bent.root_joint, {.matrix = moved(0, 3, 0)});
            other = scene.add_node(scene.root(), {.matrix = moved(0, 0, 5)});
            scene.set_parent(bent.tip_joint, arm);
        }
        Box3d bounds() { return bent.scene.bounds(); }
    };
    const auto expect_same = [](Case& a, Case& b, const char* what) {
        EXPECT_EQ(a.bounds().lo, b.bounds().lo) << what;
        EXPECT_EQ(a.bounds().hi, b.bounds().hi) << what;
    };
    // Of the two joints the tip stays, whose former ancestor the other one is.
    const auto without_root_joint = [](Case& c) {
        Skin skin = c.bent.scene.skin(c.bent.skin);
        skin.joints[0] = c.bent.scene.add_node(c.other, {});
        c.bent.scene.set_skin(c.bent.skinned, c.bent.scene.add(skin));
        return skin.joints[0];
    };
    Case before, after, back;
    before.bent.scene.remove(without_root_joint(before));
    before.bent.scene.set_parent(before.bent.tip_joint, before.other);
    const NodeId joint = without_root_joint(after);
    after.bent.scene.set_parent(after.bent.tip_joint, after.other);
    after.bent.scene.refit();
    after.bent.scene.remove(joint);
    expect_same(before, after, "removed before and after the other one was hung elsewhere");

    back.bent.scene.remove(without_root_joint(back));
    Case still;
    still.bent.scene.remove(without_root_joint(still));
    back.bent.scene.refit();
    back.bent.scene.set_parent(back.bent.tip_joint, back.other);
    back.bent.scene.set_parent(back.bent.tip_joint, back.arm);
    expect_same(back, still, "there and back");

    const NodeId copied = still.bent.scene.copy(still.bent.skinned, still.bent.scene.root());
    const Box3d original = still.bounds();
    still.bent.scene.remove(still.bent.skinned);
    EXPECT_EQ(still.bounds().lo, original.lo) << "the copy is where the original was";
    EXPECT_EQ(still.bounds().hi, original.hi);
    EXPECT_TRUE(still.bent.scene.find(copied));
}

/// Hangs the joints and what they bend below a new node.
NodeId hero_of(Bent& bent)
{
    const NodeId hero = bent.scene.add_node(bent.scene.root(), {});
    bent.scene.set_parent(bent.root_joint, hero);
    bent.scene.set_parent(bent.skinned, hero);
    return hero;
}

TEST(SceneLinks, ASkinOutlivesItsCopyIfANodeElsewhereWearsIt)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId hero = hero_of(bent);
    const NodeId copied = scene.copy(hero, scene.root());
    const NodeId armature = scene.node(copied).children.at(0), body = scene.node(copied).children.at(1);
    const SkinId skin = scene.node(body).skin;
    ASSERT_NE(skin, bent.skin);
    scene.set_transform(armature, moved(0, 0, 7));
    scene.set_parent(armature, scene.root());
    const NodeId hat = scene.add_node(scene.root(), {.cages = {bent.cage}, .skin = skin});
    scene.remove(hero);
    scene.refit();
    scene.remove(copied);
    EXPECT_EQ(scene.bounds().lo.z, 7) << "the hat is where the joints are";
    scene.remove(hat);
    EXPECT_TRUE(scene.bounds().is_empty());
    EXPECT_TRUE(scene.find(skin));

    const NodeId again = scene.copy(armature, scene.root());
    scene.remove(again);
    EXPECT_TRUE(scene.find(skin));
}

TEST(SceneLinks, SkinsOfACopyGoWithIt)
{
    Bent bent;
    Scene& scene = bent.scene;
    const NodeId hero = hero_of(bent);
    const NodeId copied = scene.copy(hero, scene.root());
    EXPECT_EQ(scene.counts().skins, 2u);
    scene.remove(copied);
    EXPECT_EQ(scene.counts().skins, 1u);
}

// An edit costs the path to the root of those that use a thing now.
TEST(SceneLinks, FormerUsersCostAnEditNothing)
{
    Bent bent;
    Scene& scene = bent.scene;
    const CageId fine = scene.add(unit_square()), coarse = scene.add(unit_square());
    const MaterialId paint = scene.add(Material{}), other = scene.add(Material{});
    const NodeId shown = scene.add_node(scene.root(), {.cages = {fine}}), now = scene.add_node(scene.root(), {});
    const NodeId crowd = scene.add_node(scene.root(), {});
    std::vector<NodeId> nodes;
    for (int i = 0; i < 2000; ++i)
        nodes.push_back(scene.add_node(
            crowd, {.cages = {fine}, .materials = {paint}, .instance_of = shown, .skin = i < 200 ? bent.skin : SkinId()}));
    scene.refit();
    for (const NodeId id : nodes) {
        scene.set_cages(id, {coarse});
        scene.set_materials(id, {other});
        scene.set_instance_of(id, now);
        scene.set_skin(id, {});
    }
    scene.refit();
    const auto visited = [&](auto&& edit) {
        edit();
        return scene.refit();
    };
    const std::vector<Vec3f> square = unit_square().positions;
    EXPECT_LT(visited([&] { scene.set_transform(shown, moved(1, 0, 0)); }), 50u);
    EXPECT_LT(visited([&] { scene.set_cages(shown, {fine, fine}); }), 50u);
    EXPECT_LT(visited([&] { scene.write_vertices(fine, square); }), 50u);
    EXPECT_LT(visited([&] { scene.set_transform(bent.tip_joint, moved(3, 0, 0)); }), 50u);
    Material glowing;
    glowing.emission = Vec3f(1);
    EXPECT_LT(visited([&] { scene.replace(paint, glowing); }), 50u);
    EXPECT_GT(visited([&] { scene.write_vertices(coarse, square); }), 1000u);
}

}  // namespace
}  // namespace occam
