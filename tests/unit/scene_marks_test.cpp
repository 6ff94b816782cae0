// What edits and refits look at grows with what was edited and with what uses it, and not with the product of the two.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/matrix.h"
#include "scenegraph/scene.h"

namespace occam {
namespace {

/// Returns a triangle, all corners of which follow the first joint of a skin.
Cage triangle_of_first_joint()
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    cage.face_vertices = {0, 1, 2};
    cage.skin.sets = 1;
    cage.skin.joints.assign(3, {0, 0, 0, 0});
    cage.skin.weights.assign(3, {1, 0, 0, 0});
    return cage;
}

/// A skin of many joints, worn by many nodes, with nodes between the joints and the base.
struct Crowd {
    static constexpr std::size_t kJoints = 40, kWearers = 50, kBetween = 30;
    Scene scene;
    CageId cage = scene.add(triangle_of_first_joint());
    NodeId base = scene.add_node(scene.root(), {.name = "base"});
    std::vector<NodeId> between{base}, joints, wearers;
    SkinId skin;

    Crowd()
    {
        for (std::size_t i = 0; i < kBetween; ++i) between.push_back(scene.add_node(between.back(), {}));
        for (std::size_t j = 0; j < kJoints; ++j) joints.push_back(scene.add_node(between.back(), {}));
        joints.push_back(scene.add_node(base, {}));  // so that the base lies above those between
        skin = scene.add(Skin{"skin", joints, {}});
        for (std::size_t w = 0; w < kWearers; ++w) wear(skin);
        scene.refit();
    }
    void wear(SkinId worn) { wearers.push_back(scene.add_node(scene.root(), {.cages = {cage}, .skin = worn})); }
    void move(NodeId node, double x) { scene.set_transform(node, Trs{.translation = {x, 0, 0}}); }
    /// Expects each wearer where the first joint is, after a refit.
    void expect_worn_at(double x, const char* after)
    {
        scene.refit();
        for (const NodeId wearer : wearers) {
            EXPECT_DOUBLE_EQ(scene.node(wearer).bounds.lo.x, x) << after;
            EXPECT_DOUBLE_EQ(scene.node(wearer).bounds.hi.x, x + 1) << after;
        }
    }
};

TEST(SceneMarks, AllJointsOfASkinMarkItsWearersOnce)
{
    Crowd crowd;
    for (int pose = 1; pose < 4; ++pose) {
        const std::size_t before = crowd.scene.looked_at();
        for (const NodeId joint : crowd.joints) crowd.move(joint, pose);
        EXPECT_LE(crowd.scene.looked_at() - before, 4 * (Crowd::kJoints + Crowd::kWearers));
        crowd.expect_worn_at(pose, "a pose");
    }
}

TEST(SceneMarks, NodesThatMoveManySkinsMarkThemOnceAPoseOfAShutter)
{
    Crowd crowd;
    constexpr std::size_t kSkins = 50, kKeys = 9;
    for (std::size_t s = 1; s < kSkins; ++s) crowd.wear(crowd.scene.add(Skin{"other", crowd.joints, {}}));
    crowd.scene.refit();
    const std::size_t before = crowd.scene.looked_at();
    crowd.scene.record_shutter(kKeys - 1, [&](double tau) {
        for (const NodeId node : crowd.between) crowd.move(node, tau);
    });
    EXPECT_LE(crowd.scene.looked_at() - before, 4 * Crowd::kBetween * (kSkins + Crowd::kWearers));
    crowd.scene.clear_shutter();
    for (const NodeId node : crowd.between) crowd.move(node, 0.25);
    crowd.expect_worn_at(0.25 * double(crowd.between.size()), "the base moves all");
}

// What is marked stays marked until the next refit alone, and what comes to use it in between is marked, too.
TEST(SceneMarks, WhatIsAddedBetweenTwoEditsIsRefitted)
{
    Crowd crowd;
    Scene& scene = crowd.scene;
    const NodeId joint = crowd.joints[0], above = crowd.between.back();
    crowd.move(joint, 1);
    crowd.wear(crowd.skin);
    crowd.move(joint, 2);
    crowd.expect_worn_at(2, "a wearer is added between two edits");
    crowd.move(joint, 3);
    crowd.expect_worn_at(3, "the joint alone");
    crowd.move(above, 1);
    crowd.wear(scene.add(Skin{"second", {crowd.joints[0], crowd.joints.back()}, {}}));
    crowd.move(above, 2);
    crowd.expect_worn_at(5, "a skin is added between two edits of a node above its joint");
    crowd.move(above, 3);
    crowd.expect_worn_at(6, "the node above alone");
    crowd.move(above, 4);
    scene.set_skin(crowd.wearers[0], {});
    scene.refit();
    EXPECT_DOUBLE_EQ(scene.node(crowd.wearers[0]).bounds.lo.x, 0) << "it wears no skin";
    crowd.move(above, 5);
    scene.set_skin(crowd.wearers[0], crowd.skin);
    crowd.move(above, 6);
    crowd.expect_worn_at(9, "a node puts on a skin between two edits");
    crowd.move(joint, 0);
    scene.remove(crowd.wearers.back());
    crowd.wearers.pop_back();
    scene.remove(crowd.skin);
    scene.refit();
    EXPECT_DOUBLE_EQ(scene.node(crowd.wearers[0]).bounds.lo.x, 0) << "its skin was removed";
}

TEST(SceneMarks, NodesDoNotLookAtEachMaterialOfTheirCage)
{
    constexpr std::size_t kSlots = 100, kNodes = 100;
    Scene scene;
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
        cage.face_vertices.insert(cage.face_vertices.end(), {0, 1, 2});
        cage.face_slots.push_back(static_cast<std::uint16_t>(slot));
        cage.materials.push_back(scene.add(Material{}));
    }
    const std::vector<MaterialId> materials = cage.materials;
    const CageId id = scene.add(std::move(cage));
    for (std::size_t n = 0; n < kNodes; ++n) scene.add_node(scene.root(), {.cages = {id}});
    const NodeId other = scene.add_node(scene.root(), {.cages = {id}, .materials = {materials[7]}});
    Material blended;
    blended.alpha_mode = AlphaMode::Blend;
    const auto expect_kinds = [&](Contents::Kinds all, Contents::Kinds of_other, const char* after) {
        const std::size_t before = scene.looked_at();
        scene.refit();
        scene.for_placements_of(Contents::Passing, [](NodeId, const Node&, const Mat4d&) {});
        EXPECT_LE(scene.looked_at() - before, 10 * (kSlots + kNodes)) << after;
        EXPECT_EQ(scene.contents().kinds, all) << after;
        EXPECT_EQ(scene.node(other).contents.kinds, of_other) << after;
    };
    expect_kinds(0, 0, "all are opaque");
    scene.replace(materials[42], blended);
    expect_kinds(Contents::Passing, 0, "one slot blends");
    const double passed = scene.contents().passing_area;
    scene.replace(materials[43], blended);
    expect_kinds(Contents::Passing, 0, "two slots blend");
    EXPECT_NEAR(scene.contents().passing_area, 2 * passed, 1e-9 * passed);
    scene.replace(materials[42], Material{});
    scene.replace(materials[43], Material{});
    scene.replace(materials[7], blended);
    expect_kinds(Contents::Passing, Contents::Passing, "the slot that one node has blends");
}

}  // namespace
}  // namespace occam
