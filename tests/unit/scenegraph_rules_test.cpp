// Tests of what a scene refuses: handles of other scenes, copies that would show themselves, and impossible values.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "scenegraph/scene.h"

namespace occam {
namespace {

Material named(const char* name)
{
    Material material;
    material.name = name;
    return material;
}

// Two scenes are made by the same steps, so handles with the same numbers would name objects in both of them.
TEST(SceneHandles, AreTheirOwnScenesAlone)
{
    struct Filled {
        Scene scene;
        NodeId node = scene.add_node(scene.root(), {});
        MaterialId material = scene.add(Material{});
        LightId light = scene.add(Light{});
        TextureId texture = scene.add(Texture{});
        CageId cage = scene.add(Cage{});
        CameraId camera = scene.add(CameraLens{});
        ClipId clip = scene.add(Clip{});
        SkinId skin = scene.add(Skin{{}, {node}, {}});
    };
    Filled a, b;
    EXPECT_NE(a.node, b.node);
    EXPECT_THROW(a.scene.node(b.node), Error);
    EXPECT_THROW(a.scene.add_node(b.scene.root(), {}), Error);
    EXPECT_THROW(a.scene.set_transform(b.node, Trs{}), Error);
    EXPECT_THROW(a.scene.remove(b.node), Error);
    EXPECT_THROW(a.scene.replace(b.material, Material{}), Error);
    EXPECT_THROW(a.scene.set_materials(a.node, {b.material}), Error);
    EXPECT_THROW(a.scene.set_skin(a.node, b.skin), Error);
    EXPECT_THROW(a.scene.pose(b.clip, 0), Error);
    EXPECT_THROW(a.scene.light(b.light), Error);
    EXPECT_THROW(a.scene.texture(b.texture), Error);
    EXPECT_THROW(a.scene.remove(b.cage), Error);
    EXPECT_THROW(a.scene.remove(b.material), Error);
    EXPECT_THROW(a.scene.remove(b.texture), Error);
    EXPECT_THROW(a.scene.replace(b.texture, Texture{}), Error);
    EXPECT_THROW(a.scene.remove(b.camera), Error);
    EXPECT_THROW(a.scene.remove(b.clip), Error);
    EXPECT_EQ(a.scene.find(b.node), nullptr);
    const Scene moved = std::move(a.scene);
    EXPECT_NO_THROW(moved.node(a.node));
    EXPECT_THROW(moved.node(b.node), Error);
}

// Nothing would tell that the texture of another scene is not seen.
TEST(SceneHandles, AreCheckedInMaterialsAndCages)
{
    Scene scene, other;
    const MaterialId known = scene.add(Material{});
    const CageId cage = scene.add(Cage{});
    Material foreign;
    foreign.anisotropy_texture.texture = other.add(Texture{});
    EXPECT_THROW(scene.add(foreign), Error);
    EXPECT_THROW(scene.replace(known, foreign), Error);
    Cage painted;
    painted.materials = {known, other.add(Material{})};
    EXPECT_THROW(scene.add(painted), Error);
    EXPECT_THROW(scene.replace(cage, painted), Error);
    EXPECT_EQ(scene.counts().materials, 1u);
    EXPECT_EQ(scene.counts().cages, 1u);
    painted.materials = {known, MaterialId()};
    EXPECT_NO_THROW(scene.add(painted)) << "a slot may have the default material";
}

TEST(SceneRules, ValuesThatNothingCanHaveAreRefused)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    const MaterialId known = scene.add(named("known"));
    const float nan = std::nanf("");
    const auto refuses = [&](auto change) {
        Material m = named("paint");
        change(m);
        EXPECT_THROW(scene.add(m), Error);
        EXPECT_THROW(scene.replace(known, m), Error);
    };
    refuses([&](Material& m) { m.base_color.x = nan; });
    refuses([&](Material& m) { m.base_color.w = -1; });
    refuses([&](Material& m) { m.emission.y = INFINITY; });
    refuses([&](Material& m) { m.roughness = -0.1f; });
    refuses([&](Material& m) { m.roughness = nan; });
    refuses([&](Material& m) { m.metallic = 1.5f; });
    refuses([&](Material& m) { m.ior = nan; });
    refuses([&](Material& m) { m.clearcoat_roughness = -1; });
    refuses([&](Material& m) { m.sheen_color.y = nan; });
    refuses([&](Material& m) { m.sheen_roughness = 2; });
    refuses([&](Material& m) { m.anisotropy = -1; });
    refuses([&](Material& m) { m.anisotropy_rotation = nan; });
    refuses([&](Material& m) { m.sheen_color_texture.rotation = nan; });
    refuses([&](Material& m) { m.anisotropy_texture.scale.x = nan; });
    refuses([&](Material& m) { m.glossiness_texture.offset.y = nan; });
    refuses([&](Material& m) { m.normal_texture.scale.x = nan; });
    for (const float share : {-0.1f, 1.1f, 3e38f, nan}) {
        refuses([&](Material& m) { m.specular = share; });
        refuses([&](Material& m) { m.occlusion_strength = share; });
    }
    for (const float angle : {-0.1f, 3.15f, 1e20f, nan}) {
        EXPECT_THROW(scene.add(Light{"l", PointLight{.outer_angle = angle}}), Error) << angle;
        EXPECT_THROW(scene.add(Light{"l", PointLight{.inner_angle = angle}}), Error) << angle;
    }
    EXPECT_EQ(scene.material(known).name, "known");
    EXPECT_THROW(scene.add(Light{"l", PointLight{Vec3f(nan)}}), Error);
    EXPECT_THROW(scene.add(Light{"l", SunLight{Vec3f(-1)}}), Error);
    EXPECT_THROW(scene.add(Light{"l", AreaLight{AreaLight::Shape::Disc, Vec2f(-1)}}), Error);
    for (const float fov : {0.0f, 0.9e-5f, 3.1415f}) EXPECT_THROW(scene.add(CameraLens{.fov = fov}), Error) << fov;
    for (const float fov : {1e-5f, 3.14f}) EXPECT_NO_THROW(scene.add(CameraLens{.fov = fov})) << fov;
    EXPECT_THROW(scene.set_transform(node, Trs{.rotation = Vec4d(0)}), Error);
    EXPECT_THROW(scene.set_transform(node, Trs{.rotation = Vec4d(double(nan))}), Error);
    EXPECT_THROW(scene.add_node(node, {.place = {.rotation = Vec4d(0)}}), Error);
    EXPECT_THROW(scene.set_transform(node, Trs{.rotation = Vec4d(0, 1, 0, 1)}), Error);
    try {
        Material m = named("paint");
        m.roughness = -1;
        scene.add(m);
        FAIL();
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "the roughness must be from 0 to 1 (material 'paint')");
    }
}

TEST(SceneRules, NodesAndSkinsNeedNumbers)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    for (const float bad : {std::nanf(""), INFINITY}) {
        EXPECT_THROW(scene.add_node(node, {.name = "face", .morph_weights = {0, bad}}), Error);
        EXPECT_THROW(scene.set_morph_weights(node, {bad}), Error);
        EXPECT_THROW(scene.add(Skin{"spine", {node}, {Mat4d(double(bad))}}), Error);
    }
    EXPECT_EQ(scene.counts().nodes, 2u);
    EXPECT_EQ(scene.counts().skins, 0u);
}

// Products with another last row move what lies below, and bounds do not know of it.
TEST(SceneRules, TransformsAreAffine)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    Mat4d bad[4] = {Mat4d(2), Mat4d(1), Mat4d(1), Mat4d(1)};
    bad[1][0][3] = 1;
    bad[2][3][3] = 0;
    bad[3][1][3] = std::nan("");
    for (const Mat4d& m : bad) {
        EXPECT_THROW(scene.set_transform(node, m), Error);
        EXPECT_THROW(scene.add_node(node, {.matrix = m}), Error);
        EXPECT_THROW(scene.add(Skin{"spine", {node}, {m}}), Error);
    }
    EXPECT_EQ(scene.world_from_node(node), Mat4d(1));
    Mat4d rounded(1);
    rounded[3] = Vec4d(1, 2, 3, 1 + 1e-15);
    scene.set_transform(node, rounded);
    EXPECT_EQ(scene.node(node).parent_from_node[3], Vec4d(1, 2, 3, 1)) << "an inverse may be rounded";
}

TEST(SceneRules, ACopyThatWouldShowItselfIsRefused)
{
    Scene scene;
    const NodeId shown = scene.add_node(scene.root(), {}), below = scene.add_node(shown, {});
    const NodeId group = scene.add_node(scene.root(), {});
    scene.add_node(group, {.instance_of = shown});
    const NodeId other = scene.add_node(scene.root(), {}), by_way = scene.add_node(other, {.instance_of = group});
    const std::size_t nodes = scene.counts().nodes;
    EXPECT_THROW(scene.copy(group, shown), Error);
    EXPECT_THROW(scene.copy(group, below), Error);
    EXPECT_THROW(scene.copy(other, below), Error) << "by way of another instance";
    EXPECT_THROW(scene.copy(by_way, group), Error);
    EXPECT_EQ(scene.counts().nodes, nodes) << "a refused edit changes nothing";
    EXPECT_NO_THROW(scene.copy(group, other));
    EXPECT_NO_THROW(scene.copy(below, shown));
    // An instance of what is copied with it shows the copy of that.
    const NodeId pair = scene.add_node(scene.root(), {}), first = scene.add_node(pair, {});
    scene.add_node(pair, {.instance_of = first});
    const NodeId copy = scene.copy(pair, scene.root());
    EXPECT_EQ(scene.node(scene.node(copy).children.at(1)).instance_of, scene.node(copy).children.at(0));
    scene.refit();
}

TEST(SceneRules, AClipsChannelsAreWhole)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    Channel good;
    good.target = node;
    good.times = {0, 1};
    good.values = {0, 0, 0, 1, 1, 1};
    EXPECT_NO_THROW(scene.add(Clip{"good", {good}}));
    const auto refuses = [&](auto change) {
        Channel c = good;
        change(c);
        EXPECT_THROW(scene.add(Clip{"bad", {c}}), Error);
    };
    refuses([](Channel& c) { c.values.pop_back(); });
    refuses([](Channel& c) { c.width = 4; });
    refuses([](Channel& c) { c.width = -3; });
    refuses([](Channel& c) { c.times = {1, 1}; });
    refuses([](Channel& c) { c.times = {1, 0}; });
    refuses([](Channel& c) { c.times[1] = std::nanf(""); });
    refuses([](Channel& c) { c.values[2] = INFINITY; });
    refuses([](Channel& c) { c.interpolation = Channel::Interpolation::CubicSpline; });
    refuses([](Channel& c) { c.path = Channel::Path::Rotation; });
    refuses([](Channel& c) { c.path = Channel::Path::Rotation, c.width = 4, c.values.assign(8, 0.0f); });
    EXPECT_EQ(scene.clips().size(), 1u);
}

}  // namespace
}  // namespace occam
