// Edits of a scene that run out of memory are done as a whole or not at all.
#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "occam/occam.h"
#include "tests/faults/fail_everywhere.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// A scene that changes step by step.
struct World {
    Scene scene;
    CageId ring, box, coat;
    MaterialId paint;
    TextureId pattern;
    CameraId lens;
    LightId lamp;
    SkinId skin;
    ClipId clip;
    NodeId house, shown, copied, lit, joint, worn;
};

struct Step {
    std::function<void(World&)> edit;
    bool is_whole = true;  ///< a failure leaves everything as it was
};

Clip turning(NodeId node)
{
    Clip clip;
    clip.name = "turning";
    Channel channel;
    channel.target = node;
    channel.path = Channel::Path::Translation;
    channel.width = 3;
    channel.times = {0, 1};
    channel.values = {0, 0, 0, 1, 2, 3};
    clip.channels = {channel};
    return clip;
}

Cage skinned()
{
    Cage cage = torus(5, 4);
    add_skin(cage);
    return cage;
}

Cage with_a_warning()
{
    Cage cage = prism(5);
    cage.positions[0].x = std::numeric_limits<float>::quiet_NaN();
    return cage;
}

Material paint()
{
    Material material;
    material.name = "a paint with a name that is not short";
    return material;
}

Texture pattern(float shade)
{
    Texture texture;
    texture.name = "a pattern with a name that is not short";
    texture.width = 2, texture.height = 1;
    texture.pixels = {Vec4f(shade), Vec4f(1)};
    return texture;
}

/// Returns a scene with one thing of each kind.
Scene another_scene()
{
    Scene scene;
    Material patterned = paint();
    patterned.base_color_texture.texture = scene.add(pattern(0.5f));
    Cage ring = with_a_warning();
    ring.materials = {scene.add(std::move(patterned))};
    const NodeId node = scene.add_node(scene.root(),
                                       {.name = "a node with a name that is not short", .matrix = moved(1, 1, 0)});
    const SkinId skin = scene.add(Skin{"a skin with a name that is not short", {node}, {}});
    const LightId light = scene.add(Light{"a light with a name that is not short", PointLight{Vec3f(1)}});
    scene.add_node(node, {.cages = {scene.add(std::move(ring))}, .light = light, .camera = scene.add(CameraLens{})});
    scene.add_node(scene.root(), {.matrix = moved(0, -1, 0), .instance_of = node});
    scene.set_skin(scene.add_node(scene.root(), {.cages = {scene.add(skinned())}}), skin);
    scene.add(turning(node));
    return scene;
}

/// Each step edits the scene once.
const std::vector<Step> kSteps = {
    {[](World& w) { w.paint = w.scene.add(paint()); }},
    {[](World& w) { w.ring = w.scene.add(torus(6, 4)); }},
    {[](World& w) { w.box = w.scene.add(with_a_warning()); }},
    {[](World& w) {
        w.lamp = w.scene.add(Light{"a lamp with a name that is not short", PointLight{Vec3f(9)}});
    }},
    {[](World& w) { w.house = w.scene.add_node(w.scene.root(), {.name = "a house", .cages = {w.ring}}); }},
    {[](World& w) {
        w.shown = w.scene.add_node(w.house, {.matrix = moved(2, 0, 0), .cages = {w.box, w.ring}});
    }},
    {[](World& w) { w.lit = w.scene.add_node(w.house, {.matrix = moved(0, 3, 0), .light = w.lamp}); }},
    {[](World& w) { w.joint = w.scene.add_node(w.house, {.name = "a joint"}); }},
    {[](World& w) {
        w.skin = w.scene.add(Skin{"a skin with a name that is not short", {w.joint, w.house}, {}});
    }},
    {[](World& w) { w.coat = w.scene.add(skinned()); }},
    {[](World& w) { w.worn = w.scene.add_node(w.scene.root(), {.cages = {w.coat}}); }},
    {[](World& w) { w.scene.set_skin(w.worn, w.skin); }},
    {[](World& w) { w.scene.add_node(w.scene.root(), {.matrix = moved(0, 0, -3), .instance_of = w.house}); }},
    {[](World& w) { w.scene.refit(); }},
    {[](World& w) { w.scene.set_transform(w.shown, moved(0, 2, 1)); }},
    {[](World& w) { w.scene.set_materials(w.shown, {w.paint}); }},
    {[](World& w) { w.scene.set_transform(w.joint, moved(0.5, 0, 0)); }},
    {[](World& w) { w.clip = w.scene.add(turning(w.shown)); }},
    {[](World& w) { w.scene.pose(w.clip, 0.5); }},
    {[](World& w) { w.copied = w.scene.copy(w.house, w.scene.root()); }},
    {[](World& w) { w.scene.set_transform(w.copied, moved(-2, 0, 0)); }},
    {[](World& w) { w.scene.refit(); }},
    {[](World& w) { w.pattern = w.scene.add(pattern(0.25f)); }},
    {[](World& w) {
        Material patterned = paint();
        patterned.base_color_texture.texture = w.pattern;
        w.scene.replace(w.paint, std::move(patterned));
    }},
    {[](World& w) { w.scene.replace(w.pattern, pattern(0.75f)); }},
    {[](World& w) { w.lens = w.scene.add(CameraLens{}); }},
    {[](World& w) { w.scene.set_parent(w.joint, w.copied); }},
    {[](World& w) { w.scene.set_parent(w.worn, w.joint); }},
    {[](World& w) { w.scene.set_parent(w.joint, w.house); }},
    {[](World& w) {
        w.scene.set_cages(w.shown, {w.ring, w.box, w.ring});
    }},
    {[](World& w) { w.scene.set_camera(w.shown, w.lens); }},
    {[](World& w) { w.scene.set_light(w.joint, w.lamp); }},
    {[](World& w) { w.scene.set_instance_of(w.worn, w.shown); }},
    {[](World& w) { w.scene.add(another_scene(), w.house); }},
    {[](World& w) { w.scene.replace(w.ring, torus(7, 5)); }},
    {[](World& w) { w.scene.write_vertices(w.box, prism(5).positions); }},
    {[](World& w) { w.scene.set_visible(w.joint, false); }},
    {[](World& w) { w.scene.pose({}); }},
    {[](World& w) { w.scene.remove(w.lit); }},
    {[](World& w) { w.scene.remove(w.shown); }},
    {[](World& w) { w.scene.remove(w.lamp); }},
    {[](World& w) {
         w.scene.record_shutter(2, [&](double tau) {
             w.scene.set_transform(w.house, moved(tau, 0, 0));
             std::vector<Vec3f> moved_up = torus(7, 5).positions;
             for (Vec3f& p : moved_up) p.y += static_cast<float>(tau);
             w.scene.write_vertices(w.ring, moved_up);
         });
     },
     false},
    {[](World& w) { w.scene.refit(); }},
    {[](World& w) { w.scene.remove(w.copied); }},
    {[](World& w) { w.scene.remove(w.paint); }},
    {[](World& w) { w.scene.remove(w.pattern); }},
    {[](World& w) { w.scene.remove(w.lens); }},
    {[](World& w) { w.scene.remove(w.clip); }},
    {[](World& w) { w.scene.clear_shutter(); }},
};

/// Says what a scene holds, and what its picture looks like.
struct Outcome {
    Box3d bounds;
    Contents contents;
    std::size_t nodes, cages, lights, clips, skins, materials, textures, cameras, faces, placed, warnings;
    std::uint64_t picture;

    explicit Outcome(Scene& scene)
    {
        bounds = scene.bounds();
        contents = scene.contents();
        const Scene::Counts counts = scene.counts();
        nodes = counts.nodes, cages = counts.cages, lights = counts.lights, clips = counts.clips, skins = counts.skins;
        materials = counts.materials, textures = counts.textures, cameras = counts.cameras;
        faces = counts.faces, placed = scene.placed_faces(), warnings = scene.warnings.size();
        picture = Renderer({.threads = 1})
                      .render(scene, Camera::look_at({1, 2, 9}, Vec3d(0), {0, 1, 0}, 0.8f),
                              {.width = 8, .height = 6, .spp = 1, .integrator = IntegratorKind::Direct})
                      .checksum();
    }
    void expect(const Outcome& wanted) const
    {
        EXPECT_EQ(bounds.lo, wanted.bounds.lo);
        EXPECT_EQ(bounds.hi, wanted.bounds.hi);
        EXPECT_TRUE(contents == wanted.contents);
        EXPECT_EQ(nodes, wanted.nodes);
        EXPECT_EQ(cages, wanted.cages);
        EXPECT_EQ(lights, wanted.lights);
        EXPECT_EQ(clips, wanted.clips);
        EXPECT_EQ(skins, wanted.skins);
        EXPECT_EQ(materials, wanted.materials);
        EXPECT_EQ(textures, wanted.textures);
        EXPECT_EQ(cameras, wanted.cameras);
        EXPECT_EQ(faces, wanted.faces);
        EXPECT_EQ(placed, wanted.placed);
        EXPECT_EQ(warnings, wanted.warnings);
        EXPECT_EQ(picture, wanted.picture);
    }
};

void take_steps(World& world, std::size_t from, std::size_t to)
{
    for (std::size_t i = from; i < to; ++i) kSteps[i].edit(world);
}

Outcome outcome_after(std::size_t steps)
{
    World world;
    take_steps(world, 0, steps);
    return Outcome(world.scene);
}

/// Fails allocations of each step, and checks each scene as check(step, world, has_thrown) does.
template <class Check>
void fail_steps(Density density, Check&& check)
{
    for (std::size_t step = 0; step < kSteps.size(); ++step) {
        SCOPED_TRACE(testing::Message() << "step " << step);
        std::optional<World> world;
        const auto begin = [&] {
            world.emplace();
            take_steps(*world, 0, step);
        };
        begin();
        fail_everywhere(
            density, [&] { kSteps[step].edit(*world); },
            [&](bool has_thrown) {
                check(step, *world, has_thrown);
                begin();
            });
    }
}

// Scenes are compared at once, since repeating the edit would complete a half of it.
TEST(FailingEdits, AreDoneAsAWholeOrNotAtAll)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    std::vector<Outcome> after;
    for (std::size_t steps = 0; steps <= kSteps.size(); ++steps) after.push_back(outcome_after(steps));
    fail_steps({.dense = 24, .growth = 1.3}, [&](std::size_t step, World& world, bool has_thrown) {
        if (kSteps[step].is_whole) Outcome(world.scene).expect(after[has_thrown ? step : step + 1]);
    });
}

// Nobody looks at these scenes before they go on, and their end tells what they have become.
TEST(FailingEdits, LeaveScenesThatGoOnAsIfNothingHadFailed)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    const Outcome end = outcome_after(kSteps.size());
    fail_steps({.dense = 3, .growth = 5}, [&](std::size_t step, World& world, bool has_thrown) {
        if (has_thrown) kSteps[step].edit(world);
        take_steps(world, step + 1, kSteps.size());
        Outcome(world.scene).expect(end);
    });
}

// Renderers in other threads may read a scene while one of them makes sure that it is up to date.
TEST(FailingEdits, TheRefitOfACleanSceneNeedsNoMemoryAndWritesNothing)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    Scene scene = another_scene();
    scene.refit();
    const auto check = [&](bool has_thrown) {
        EXPECT_FALSE(has_thrown);
        EXPECT_FALSE(scene.node(scene.root()).dirty);
    };
    fail_everywhere(
        {}, [&] { scene.refit(); }, check);
}

TEST(FailingEdits, ASkinThatCannotBePutOnLeavesTheKeysOfItsNode)
{
    if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    Scene scene;
    const NodeId joint = scene.add_node(scene.root(), {}), above = scene.add_node(scene.root(), {}),
                 worn = scene.add_node(above, {.cages = {scene.add(skinned())}});
    const auto skin_of = [&] { return scene.add(Skin{"", {joint}, {}}); };
    SkinId skin = skin_of();
    const auto record = [&] { scene.record_shutter(2, [&](double tau) { scene.set_transform(worn, moved(tau, 1, 0)); }); };
    record();
    const auto check = [&](bool has_thrown) {
        EXPECT_EQ(scene.node(worn).keys.size(), has_thrown ? 3u : 0u);
        EXPECT_EQ(bool(scene.node(worn).skin), !has_thrown);
        if (has_thrown) scene.set_skin(worn, skin);
        scene.set_skin(worn, {});
        scene.remove(skin);
        skin = skin_of();
        record();
    };
    fail_everywhere(
        {}, [&] { scene.set_skin(worn, skin); }, check);
}

}  // namespace
}  // namespace occam::test
