// Tests of scenes that are put together from other scenes, such as those of several files.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "occam/occam.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using test::moved;

const Camera kCamera = Camera::look_at({1, 3, 9}, {1, 0, 0}, {0, 1, 0}, 0.8f);
const Settings kSmall{.width = 64, .height = 36, .spp = 2};

Clip clip_of(NodeId node, Vec3f end)
{
    Clip clip;
    clip.name = "goes";
    Channel channel;
    channel.target = node;
    channel.times = {0, 1};
    channel.values = {0, 0, 0, end.x, end.y, end.z};
    clip.channels = {channel};
    return clip;
}

Texture stripes()
{
    Texture texture;
    texture.width = 4, texture.height = 1;
    texture.pixels = {Vec4f(0.1f), Vec4f(0.9f), Vec4f(0.3f), Vec4f(1)};
    return texture;
}

/// What one of our files might hold: a displaced and textured thing, a skin, a cage on demand, an instance, a lamp, a clip.
struct Part {
    Scene scene;
    NodeId thing, joint;
    CageId cage;
    TextureId texture;
    ClipId clip;

    /// Builds it below a node of a scene, with all handles of that scene.
    void build(Scene& into, NodeId top, Vec3f color, double x)
    {
        texture = into.add(stripes());
        Material paint;
        paint.base_color = Vec4f(color, 1);
        paint.base_color_texture.texture = texture;
        const MaterialId material = into.add(paint);

        Cage square = test::textured_square();
        square.materials = {material};
        Displacement waves;
        waves.texture.texture = texture;
        waves.scale = waves.bound = 0.3f;
        square.displacement = waves;
        cage = into.add(square);
        thing = into.add_node(top, {.name = "thing", .matrix = moved(x, 0, 0), .cages = {cage}});

        joint = into.add_node(thing, {.name = "joint"});
        Cage ring = test::torus(5, 4);
        ring.materials = {material};
        test::add_skin(ring);
        const SkinId skin = into.add(Skin{"bones", {joint, thing}, {}});
        const NodeId worn = into.add_node(top, {.cages = {into.add(ring)}, .materials = {material}});
        into.set_skin(worn, skin);

        OnDemandCage late;
        late.bounds.add(Vec3d(-1.5));
        late.bounds.add(Vec3d(1.5));
        late.make = [] { return test::creased_cube(2); };
        late.materials = {material};
        into.add_node(top, {.matrix = moved(x, -2.5, 0), .cages = {into.add(std::move(late))}});
        into.add_node(top, {.matrix = moved(0, 2.5, 0), .instance_of = thing});
        const LightId lamp = into.add(Light{"lamp", PointLight{Vec3f(40) * color}});
        into.add_node(top, {.matrix = moved(x, 2, 5), .light = lamp, .camera = into.add(CameraLens{})});
        clip = into.add(clip_of(joint, {0, 1, 1}));
    }
    Part(Vec3f color, double x) { build(scene, scene.root(), color, x); }
    Part(Scene& into, NodeId top, Vec3f color, double x) { build(into, top, color, x); }
};

const Vec3f kRed{0.8f, 0.2f, 0.1f}, kBlue{0.1f, 0.3f, 0.9f};

std::uint64_t picture(Scene& scene) { return Renderer({.threads = 1}).render(scene, kCamera, kSmall).checksum(); }

TEST(SceneParts, ShowWhatTheSameThingsShowInOneScene)
{
    Scene together;
    const NodeId left = together.add_node(together.root(), {.matrix = moved(-1, 0, 0)});
    const Part red(together, left, kRed, 0), blue(together, together.root(), kBlue, 2.5);

    Scene scene;
    const NodeId place = scene.add_node(scene.root(), {.matrix = moved(-1, 0, 0)});
    const AddedScene first = scene.add(std::move(Part(kRed, 0).scene), place);
    const AddedScene second = scene.add(std::move(Part(kBlue, 2.5).scene), scene.root());
    const std::uint64_t at_rest = picture(scene);
    EXPECT_EQ(at_rest, picture(together));

    // Each clip moves the part that it came with.
    ASSERT_EQ(first.clips.size(), 1u);
    ASSERT_EQ(second.clips.size(), 1u);
    scene.pose(second.clips[0], 0.7);
    together.pose(blue.clip, 0.7);
    EXPECT_NE(picture(scene), at_rest);
    EXPECT_EQ(picture(scene), picture(together));
    scene.pose(first.clips[0], 0.4);
    together.pose(red.clip, 0.4);
    EXPECT_EQ(picture(scene), picture(together));
}

TEST(SceneParts, HavePosesOfTheirOwn)
{
    Scene scene;
    Part walker(kRed, 0);
    walker.scene.pose(walker.clip, 0.3);  // what a part was posed by before it was added belongs to its pose
    const AddedScene first = scene.add(std::move(walker.scene), scene.root());
    const AddedScene second = scene.add(std::move(Part(kBlue, 2.5).scene), scene.root());
    const NodeId copy = scene.copy(first.node, scene.root());
    const auto moved_by = [&](const AddedScene& part, double seconds) {
        const ClipAt at{part.clips[0], seconds};
        scene.pose({&at, 1}, part.node);
    };
    const auto joints = [&] {
        std::vector<Mat4d> places;
        for (const NodeId top : {first.node, second.node, copy})
            places.push_back(scene.world_from_node(scene.find_node("joint", top)));
        return places;
    };
    scene.pose({}, first.node);
    const std::vector<Mat4d> rest = joints();
    moved_by(first, 0.4);
    const std::vector<Mat4d> one = joints();
    EXPECT_NE(one[0], rest[0]);
    EXPECT_EQ(one[1], rest[1]);
    EXPECT_EQ(one[2], rest[2]);
    moved_by(second, 0.7);
    EXPECT_EQ(joints()[0], one[0]) << "another part was posed";
    EXPECT_NE(joints()[1], rest[1]);
    scene.pose({}, first.node);
    EXPECT_EQ(joints()[0], rest[0]);
    EXPECT_NE(joints()[1], rest[1]);

    // The clips of another part name nothing of this one.
    const ClipAt others{second.clips[0], 0.9};
    scene.pose({&others, 1}, first.node);
    EXPECT_EQ(joints()[0], rest[0]);
    EXPECT_THROW(scene.pose({&others, 1}, scene.root()), Error);
}

TEST(SceneParts, AreFoundByNameEachInItsOwnSubtree)
{
    Scene scene;
    const AddedScene first = scene.add(std::move(Part(kRed, 0).scene), scene.root());
    const AddedScene second = scene.add(std::move(Part(kBlue, 2.5).scene), scene.root());
    const NodeId one = scene.find_node("thing", first.node), other = scene.find_node("thing", second.node);
    ASSERT_TRUE(one && other);
    EXPECT_NE(one, other);
    EXPECT_EQ(scene.find_node("thing"), one);
    EXPECT_EQ(scene.node(other).parent, second.node);
    EXPECT_EQ(scene.find_node("thing", one), one);
    EXPECT_FALSE(scene.find_node("thing", scene.find_node("joint", first.node)));
    EXPECT_EQ(scene.clip(second.clips[0]).channels[0].target, scene.find_node("joint", second.node));
}

TEST(SceneParts, ReferToTheirNewHandlesAlone)
{
    Part part(kRed, 0);
    const NodeId thing = part.thing;
    const CageId cage = part.cage;
    const TextureId texture = part.texture;
    part.scene.environment = {Vec3f(0.5f), texture, 1};
    Scene scene;
    scene.add(stripes());
    const AddedScene added = scene.add(std::move(part.scene), scene.root());
    EXPECT_FALSE(scene.find(thing));
    EXPECT_FALSE(scene.find(cage));
    EXPECT_FALSE(scene.find(texture));
    EXPECT_TRUE(scene.find(added.environment.image));
    EXPECT_EQ(added.environment.radiance, Vec3f(0.5f));
    EXPECT_FALSE(scene.environment.image) << "the environment is the application's to choose";

    // What is used cannot be removed, and all of it can be removed in the order that scene.h gives.
    EXPECT_THROW(scene.remove(added.environment.image), Error);
    const CageSlot& moved_cage = scene.cage(scene.node(scene.find_node("thing")).cages.at(0));
    const CageId id = moved_cage.id;
    const MaterialId material = moved_cage.cage.materials.at(0);
    EXPECT_THROW(scene.remove(material), Error);
    scene.remove(added.node);
    scene.remove(id);
    EXPECT_EQ(scene.counts().nodes, 1u);
}

TEST(SceneParts, KeepThePosesOfCopiesWhoseOriginalIsGone)
{
    const auto build = [](Scene& scene, ClipId& clip) {
        const Part part(scene, scene.root(), kRed, 0);
        const NodeId copy = scene.copy(part.thing, scene.root());
        scene.set_transform(copy, moved(1.5, 0, 0));
        clip = part.clip;
        scene.remove(part.thing);
        return copy;
    };
    Scene alone, part, scene;
    ClipId clip, unused;
    const NodeId copy = build(alone, clip);
    build(part, unused);
    const AddedScene added = scene.add(std::move(part), scene.root());
    const ClipAt before{clip, 0.8}, now{added.clips[0], 0.8};
    alone.pose({&before, 1}, copy);
    scene.pose({&now, 1}, scene.node(added.node).children.back());
    EXPECT_EQ(scene.world_from_node(scene.find_node("joint")), alone.world_from_node(alone.find_node("joint")));
    EXPECT_EQ(picture(scene), picture(alone));
}

TEST(SceneParts, AreRefusedWhereTheyCannotBeAdded)
{
    Scene scene;
    const NodeId gone = scene.add_node(scene.root(), {});
    scene.remove(gone);
    EXPECT_THROW(scene.add(std::move(Part(kRed, 0).scene), gone), Error);
    Part part(kRed, 0);
    Scene moved_to = std::move(part.scene);
    EXPECT_THROW(scene.add(std::move(part.scene), scene.root()), Error);
    EXPECT_EQ(scene.counts().nodes, 1u);
    EXPECT_EQ(scene.counts().textures, 0u);
    EXPECT_EQ(scene.counts().faces, 0u);
    {
        const Scene::FrameLock frame(scene);
        EXPECT_THROW(scene.add(std::move(moved_to), scene.root()), Error);
    }
    {
        const Scene::FrameLock frame(moved_to);
        EXPECT_THROW(scene.add(std::move(moved_to), scene.root()), Error);
    }
    EXPECT_THROW(scene.add(std::move(moved_to), gone), Error);
    EXPECT_THROW(scene.add(std::move(scene), scene.root()), Error);
    EXPECT_GT(moved_to.counts().nodes, 5u) << "a scene that is refused stays as it is";
    EXPECT_NO_THROW(scene.add(std::move(moved_to), scene.root()));
}

TEST(SceneParts, LookTheSameToARendererThatHasSeenThem)
{
    Renderer renderer({.threads = 1});
    Part part(kRed, 0);
    part.scene.environment.image = part.texture;
    const std::uint64_t alone = renderer.render(part.scene, kCamera, kSmall).checksum();
    Query query(renderer, part.scene, kCamera, 36);
    query.end();
    Scene scene;
    const AddedScene added = scene.add(std::move(part.scene), scene.root());
    scene.environment = added.environment;
    EXPECT_EQ(renderer.render(scene, kCamera, kSmall).checksum(), alone);
    EXPECT_EQ(picture(scene), alone);
}

TEST(SceneParts, AreRemovedWithAllThatCameWithThem)
{
    Scene scene;
    scene.add(std::move(Part(kBlue, 2.5).scene), scene.root());
    const std::uint64_t before = picture(scene);
    const Scene::Counts counts = scene.counts();
    for (const bool is_used : {false, true}) {
        const AddedScene added = scene.add(std::move(Part(kRed, 0).scene), scene.root());
        EXPECT_EQ(added.materials.size(), 1u);
        EXPECT_EQ(added.cages.size(), 3u);
        Material paint;
        paint.base_color_texture.texture = added.textures.at(0);
        const MaterialId user = is_used ? scene.add(paint) : MaterialId();
        scene.remove(added);
        EXPECT_EQ(picture(scene), before);
        const Scene::Counts now = scene.counts();
        EXPECT_EQ(now.nodes, counts.nodes);
        EXPECT_EQ(now.cages, counts.cages);
        EXPECT_EQ(now.lights, counts.lights);
        EXPECT_EQ(now.cameras, counts.cameras);
        EXPECT_EQ(now.clips, counts.clips);
        EXPECT_EQ(now.skins, counts.skins);
        EXPECT_EQ(now.materials, counts.materials + is_used);
        EXPECT_EQ(now.textures, counts.textures + is_used) << "something else uses it";
        EXPECT_NO_THROW(scene.remove(added)) << "all of it is gone already";
        EXPECT_EQ(scene.find(user) != nullptr, is_used);
    }
}

// A copy of several copies has one pose for each of them.
TEST(SceneParts, CopiesWithinACopyHaveTheirOwnPoses)
{
    Part part(kRed, 0);
    Scene& scene = part.scene;
    const NodeId squad = scene.add_node(scene.root(), {});
    scene.copy(part.thing, squad);
    scene.copy(part.thing, squad);
    const NodeId second = scene.copy(squad, scene.root());
    const auto joint_of = [&](int soldier) {
        return scene.node(scene.find_node("joint", scene.node(second).children.at(std::size_t(soldier))))
            .parent_from_node[3]
            .y;
    };
    for (const int soldier : {0, 1}) {
        const ClipAt at{part.clip, soldier == 0 ? 0.25 : 0.75};
        scene.pose({&at, 1}, scene.node(second).children.at(std::size_t(soldier)));
    }
    EXPECT_EQ(joint_of(0), 0.25);
    EXPECT_EQ(joint_of(1), 0.75);
    EXPECT_EQ(scene.node(part.joint).parent_from_node[3].y, 0);
}

TEST(SceneParts, LoseTheirKeysButNotTheirPlaceAtMidShutter)
{
    Part part(kRed, 0);
    part.scene.record_shutter(2, [&](double tau) { part.scene.set_transform(part.thing, moved(tau, 0, 0)); });
    Scene scene;
    scene.add(std::move(part.scene), scene.root());
    EXPECT_EQ(scene.shutter_segments(), 0);
    EXPECT_EQ(scene.node(scene.find_node("thing")).parent_from_node[3].x, 0.5);
}

// A skin stays where it was, whatever was removed of what it hangs on.
TEST(SceneParts, KeepThePlacesOfSkinsThatHaveLostJoints)
{
    enum class Lost { Nothing, OneJoint, AllJoints, Base };
    for (const Lost lost : {Lost::Nothing, Lost::OneJoint, Lost::AllJoints, Lost::Base}) {
        Scene alone, part;
        for (Scene* scene : {&alone, &part}) {
            const NodeId base = scene->add_node(scene->root(), {.matrix = moved(1, 0, 0)});
            const NodeId first = scene->add_node(base, {.matrix = moved(0, 1, 0)});
            const NodeId second = scene->add_node(first, {.matrix = moved(0, 1, 0)}),
                         third = scene->add_node(base, {.matrix = moved(0.5, 0, 0)});
            Cage ring = test::torus(5, 4);
            test::add_skin(ring);
            const SkinId skin = scene->add(Skin{"", {second, third}, {}});
            const NodeId worn = scene->add_node(scene->root(), {.matrix = moved(0, 0, -1), .cages = {scene->add(ring)}});
            scene->set_skin(worn, skin);
            if (lost == Lost::OneJoint || lost == Lost::AllJoints) scene->remove(third);
            if (lost == Lost::AllJoints) scene->remove(second);
            if (lost == Lost::Base) scene->remove(base);
        }
        Scene scene;
        const NodeId place = scene.add_node(scene.root(), {.matrix = moved(-0.75, 0, 0)});
        scene.add(std::move(part), place);
        alone.set_transform(alone.root(), moved(-0.75, 0, 0));
        EXPECT_EQ(picture(scene), picture(alone)) << int(lost);
        const Vec3d apart = scene.bounds().lo - alone.bounds().lo;
        EXPECT_LT(glm::length(apart), 1e-12) << int(lost);
    }
}

TEST(SceneParts, KeepTheOrderInWhichTheirNodesWereAdded)
{
    Scene part;
    const CameraId lens = part.add(CameraLens{});
    const NodeId a = part.add_node(part.root(), {});
    part.add_node(a, {.name = "one", .camera = lens});
    part.add_node(part.root(), {.name = "two", .camera = lens});
    Scene scene;
    scene.add(std::move(part), scene.root());
    EXPECT_EQ(scene.camera_names(), (std::vector<std::string>{"one", "two"}));
}

// A game that loads and unloads the same level had its files once for each time.
TEST(SceneParts, BringTheirFilesOnce)
{
    using Files = std::vector<std::filesystem::path>;
    Scene scene;
    scene.files = {"game.glb", "wood.png"};
    for (int round = 0; round < 3; ++round) {
        Scene part;
        part.files = {"level.glb", "wood.png", "level.glb", "a file with a name that is long.bin"};
        scene.remove(scene.add(std::move(part), scene.root()));
        EXPECT_EQ(scene.files, Files({"game.glb", "wood.png", "level.glb", "a file with a name that is long.bin"}));
    }
}

}  // namespace
}  // namespace occam
