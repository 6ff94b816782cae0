// Tests of a scene through which content is streamed: what is in use cannot be removed, what was removed is gone, and
// neither the scene nor a renderer or query grows.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "io/texture/texture_store.h"
#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using test::moved;
using test::unit_square;

const Camera kCamera = Camera::look_at({1.5, 0.5, 4}, {1.5, 0.5, 0}, {0, 1, 0}, 0.8f);
const Settings kSmall{.width = 48, .height = 24, .spp = 2};

Texture texture_of(std::string name, int side, const std::function<Vec3f(int)>& color_of)
{
    Texture texture;
    texture.name = std::move(name);
    texture.width = texture.height = side;
    for (int k = 0; k < side * side; ++k) texture.pixels.push_back(Vec4f(color_of(k), 1));
    return texture;
}
Texture flat(std::string name)
{
    return texture_of(std::move(name), 2, [](int) { return Vec3f(0.5f); });
}

Cage square_with(MaterialId material)
{
    Cage cage = unit_square();
    cage.name = "square";
    cage.materials = {material};
    cage.uv_sets = {{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {}}};
    return cage;
}

Material textured(std::string name, TextureId texture)
{
    Material material;
    material.name = std::move(name);
    material.base_color_texture.texture = texture;
    return material;
}

Displacement displacement_by(TextureId texture)
{
    Displacement displacement;
    displacement.texture.texture = texture;
    displacement.scale = displacement.bound = 0.2f;
    return displacement;
}

/// Returns the message with which a removal is refused, or nothing if it is not.
template <class Id>
std::string refusal(Scene& scene, Id id)
{
    try {
        scene.remove(id);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(SceneRemoval, IsRefusedForAMaterialThatACageOrANodeNames)
{
    Scene scene;
    const MaterialId wall = scene.add(textured("wall", {})), paint = scene.add(textured("paint", {})),
                     nameless = scene.add(Material{});
    const CageId square = scene.add(square_with(wall));
    const NodeId node = scene.add_node(scene.root(), {.name = "house", .cages = {square}, .materials = {paint}});
    EXPECT_EQ(refusal(scene, wall), "material 'wall' cannot be removed, because cage 'square' uses it");
    EXPECT_EQ(refusal(scene, paint), "material 'paint' cannot be removed, because node 'house' uses it");
    EXPECT_EQ(scene.counts().materials, 3u);
    scene.set_materials(node, {nameless});
    EXPECT_EQ(refusal(scene, paint), "");
    EXPECT_NE(refusal(scene, nameless).find("material of slot 2"), std::string::npos);
    scene.replace(square, square_with({}));
    EXPECT_EQ(refusal(scene, wall), "") << "the cage no longer names it";
    scene.remove(node);
    EXPECT_EQ(refusal(scene, nameless), "") << "a removed node does not count";
    EXPECT_EQ(scene.counts().materials, 0u);
    EXPECT_THROW(scene.material(wall), Error);
}

TEST(SceneRemoval, IsRefusedForATextureThatIsUsed)
{
    Scene scene;
    const TextureId bricks = scene.add(flat("bricks")), bumps = scene.add(flat("bumps")), sky = scene.add(flat("sky"));
    const MaterialId wall = scene.add(textured("wall", bricks));
    Cage displaced = square_with(wall);
    displaced.displacement = displacement_by(bumps);
    const CageId square = scene.add(displaced);
    scene.environment.image = sky;
    EXPECT_EQ(refusal(scene, bricks), "texture 'bricks' cannot be removed, because material 'wall' uses it");
    EXPECT_EQ(refusal(scene, bumps), "texture 'bumps' cannot be removed, because cage 'square' uses it");
    EXPECT_EQ(refusal(scene, sky), "texture 'sky' cannot be removed, because the environment uses it");
    EXPECT_EQ(scene.texture_ids(), (std::vector{bricks, bumps, sky}));
    scene.replace(wall, textured("wall", bumps));
    scene.environment.image = {};
    EXPECT_EQ(refusal(scene, bricks), "");
    EXPECT_EQ(refusal(scene, sky), "");
    scene.remove(square);
    EXPECT_NE(refusal(scene, bumps), "") << "the material uses it now";
    scene.remove(wall);
    EXPECT_EQ(refusal(scene, bumps), "");
    EXPECT_TRUE(scene.texture_ids().empty());
}

TEST(SceneRemoval, LeavesHandlesDeadWhenTheirSlotsAreTakenAgain)
{
    Scene scene;
    const auto is_dead = [&](auto thing) {
        const auto id = scene.add(thing);
        {
            const Scene::FrameLock lock(scene);
            EXPECT_THROW(scene.remove(id), Error);
        }
        scene.remove(id);
        EXPECT_THROW(scene.remove(id), Error);
        const auto next = scene.add(thing);
        EXPECT_EQ(next.slot, id.slot);
        EXPECT_NE(next, id);
        EXPECT_THROW(scene.remove(id), Error);
        return id;
    };
    const MaterialId material = is_dead(Material{});
    const TextureId texture = is_dead(flat("test"));
    const CameraId camera = is_dead(CameraLens{});
    const ClipId clip = is_dead(Clip{});
    EXPECT_EQ(scene.find(material), nullptr);
    EXPECT_EQ(scene.find(texture), nullptr);
    EXPECT_EQ(scene.find(clip), nullptr);
    EXPECT_THROW(scene.add(square_with(material)), Error);
    EXPECT_THROW(scene.add(textured("test", texture)), Error);
    EXPECT_THROW(scene.replace(texture, flat("test")), Error);
    EXPECT_THROW(scene.add_node(scene.root(), {.camera = camera}), Error);
    EXPECT_THROW(scene.pose(clip, 0), Error);
}

TEST(SceneRemoval, OfACameraLeavesANodeWithoutOne)
{
    Scene scene;
    const CameraId lens = scene.add(CameraLens{});
    const NodeId node = scene.add_node(scene.root(), {.name = "main", .camera = lens});
    scene.remove(lens);
    EXPECT_FALSE(scene.camera().has_value());
    EXPECT_TRUE(scene.camera_names().empty());
    EXPECT_NO_THROW(scene.copy(node, scene.root()));
    const NodeId other = scene.add_node(scene.root(), {.name = "other", .camera = scene.add(CameraLens{.fov = 0.5f})});
    EXPECT_EQ(scene.camera_names(), std::vector{scene.node(other).name}) << "its lens is in the same slot";
}

TEST(SceneRemoval, OfAClipLeavesItsPoseUntilTheNextOne)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {});
    Channel rises{.target = node, .times = {0, 1}, .values = {0, 0, 0, 0, 2, 0}};
    const ClipId first = scene.add(Clip{"first", {rises}}), second = scene.add(Clip{"second", {}});
    scene.pose(first, 1);
    scene.remove(first);
    EXPECT_EQ(scene.node(node).place.translation.y, 2);
    EXPECT_EQ(scene.clips(), std::vector{second});
    EXPECT_EQ(scene.clips_together(), std::vector{second});
    EXPECT_FALSE(scene.find_clip("first"));
    scene.pose(second, 0);
    EXPECT_EQ(scene.node(node).place.translation.y, 0);
}

TEST(SceneReplacement, OfATextureIsWholeOrNotAtAll)
{
    Scene scene;
    const TextureId id = scene.add(flat("before"));
    const std::uint64_t identity = scene.texture(id).identity;
    Texture bad = flat("after");
    bad.width = 3;
    EXPECT_THROW(scene.replace(id, bad), Error);
    EXPECT_EQ(scene.texture(id).name, "before");
    EXPECT_EQ(scene.texture(id).identity, identity);
    const TextureId later = scene.add(flat("later"));
    scene.replace(id, flat("after"));
    EXPECT_EQ(scene.texture(id).name, "after");
    EXPECT_NE(scene.texture(id).identity, identity);
    EXPECT_EQ(scene.texture_ids(), (std::vector{id, later})) << "it keeps its place";
}

// Each texture takes about 700 KB with its levels, so that one of the two has to be halved: the one that was added first,
// whatever slots they have.
TEST(StreamedScene, HalvesTheTexturesThatANewSceneHalves)
{
    const auto grey = [] { return texture_of("grey", 256, [](int) { return Vec3f(0.5f); }); };
    Scene scene, fresh;
    TextureUse uses[3], same[2];
    for (TextureUse& use : uses) use.texture = scene.add(grey());
    scene.remove(uses[0].texture);
    scene.remove(uses[1].texture);
    const TextureUse last{.texture = scene.add(grey())};
    for (TextureUse& use : same) use.texture = fresh.add(grey());
    TextureStore store(1'000'000), other(1'000'000);
    store.prepare(scene);
    other.prepare(fresh);
    EXPECT_EQ(store.texel_width(uses[2]), other.texel_width(same[0]));
    EXPECT_EQ(store.texel_width(last), other.texel_width(same[1]));
    EXPECT_NE(store.texel_width(last), store.texel_width(uses[2]));
}

TEST(StreamedScene, ShowsReplacedTexelsUnderTheSameHandleAndRemovedOnesUnderNone)
{
    Scene scene;
    TextureStore store(1 << 20);
    const auto of_color = [](float color) { return texture_of("test", 4, [=](int) { return Vec3f(color); }); };
    const auto seen = [&](TextureId id) { return store.sample({.texture = id}, Vec2f(0.5f), 0).x; };
    const TextureId id = scene.add(of_color(3));
    store.prepare(scene);
    EXPECT_EQ(seen(id), 3);
    scene.replace(id, of_color(5));
    store.prepare(scene);
    EXPECT_EQ(store.bytes(), 0u) << "the old texels are given back at once";
    EXPECT_EQ(seen(id), 5);
    scene.remove(id);
    const TextureId next = scene.add(of_color(7));
    EXPECT_EQ(next.slot, id.slot);
    store.prepare(scene);
    EXPECT_EQ(seen(id), 1) << "its slot is taken again";
    EXPECT_EQ(seen(next), 7);
    store.clear();
    EXPECT_EQ(store.bytes(), 0u);
    EXPECT_EQ(seen(next), 1);
}

/// A room of a level; everything in it depends on its number.
struct Room {
    NodeId node;
    CageId cage;
    MaterialId material;
    TextureId look, relief;

    Room(Scene& scene, int number)
    {
        const auto color = [=](int k) {
            return Vec3f(float((k + number) % 3), float(k * number % 5) / 2, float(k % 2)) * 0.5f;
        };
        look = scene.add(texture_of("look", 16, color));
        relief = scene.add(texture_of("relief", 8, color));
        Material surface = textured("surface", look);
        if (number % 3 == 1) surface.emission = Vec3f(1), surface.emission_texture.texture = look;
        if (number % 4 == 2) surface.alpha_mode = AlphaMode::Blend, surface.base_color.w = 0.5f;
        material = scene.add(surface);
        Cage square = square_with(material);
        if (number % 3 == 1) {
            square.scheme = Scheme::Triangles;
            square.face_sizes.clear();
            square.face_vertices = {0, 1, 2, 0, 2, 3};
        } else {
            square.displacement = displacement_by(relief);
        }
        cage = scene.add(std::move(square));
        node = scene.add_node(scene.root(), {.matrix = moved(number % 3, 0, 0), .cages = {cage}});
    }
    void remove_from(Scene& scene) const
    {
        scene.remove(node);
        scene.remove(cage);
        scene.remove(material);
        scene.remove(look);
        scene.remove(relief);
    }
};

/// Returns the image of the sky at a frame: a bright patch that moves.
Texture sky_of(int frame)
{
    return texture_of("sky", 8, [=](int k) { return Vec3f(k == (20 + frame) % 64 ? 20.0f : 0.2f); });
}

/// Returns the largest slot of all handles of a room.
std::uint32_t largest_slot(const Room& room)
{
    return std::max({room.node.slot, room.cage.slot, room.material.slot, room.look.slot, room.relief.slot});
}

// Three rooms are in the scene at a time. Each frame the oldest one goes and another one comes, and the sky changes in
// place.
TEST(StreamedScene, EveryFrameIsThatOfANewSceneAndNothingGrows)
{
    constexpr int kRooms = 3, kFrames = 12;
    Scene scene;
    const TextureId sky = scene.add(sky_of(0));
    scene.environment.radiance = Vec3f(1);
    scene.environment.image = sky;
    std::vector<Room> rooms;
    for (int number = 0; number < kRooms; ++number) rooms.emplace_back(scene, number);
    Renderer renderer({.threads = 1});
    renderer.render(scene, kCamera, kSmall);
    const Scene::Counts at_first = scene.counts();
    for (int frame = 1; frame <= kFrames; ++frame) {
        rooms.front().remove_from(scene);
        rooms.erase(rooms.begin());
        rooms.emplace_back(scene, frame + kRooms - 1);
        scene.replace(sky, sky_of(frame));
        EXPECT_LE(largest_slot(rooms.back()), 2u * kRooms + 1) << "slots are used again";

        Scene fresh;
        fresh.environment.radiance = Vec3f(1);
        fresh.environment.image = fresh.add(sky_of(frame));
        for (int k = 0; k < kRooms; ++k) Room(fresh, frame + k);
        Renderer other({.threads = 1});
        EXPECT_EQ(renderer.render(scene, kCamera, kSmall).checksum(), other.render(fresh, kCamera, kSmall).checksum());
        EXPECT_EQ(renderer.stats().memory.texture_bytes, other.stats().memory.texture_bytes);
        EXPECT_GT(renderer.stats().memory.texture_bytes, 0u);
        EXPECT_EQ(scene.counts().textures, at_first.textures);
        EXPECT_EQ(scene.counts().materials, at_first.materials);
    }
}

// The application takes out what could not be read, and asks again.
TEST(StreamedScene, AQueryForgetsADisplacementThatCouldNotBeRead)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(square_with({}))}});
    Query query(scene, kCamera);
    query.end();
    Texture unreadable;
    unreadable.encoded = std::make_shared<const std::vector<std::byte>>(64, std::byte(1));
    const TextureId texture = scene.add(unreadable);
    Cage displaced = square_with({});
    displaced.displacement = displacement_by(texture);
    const CageId cage = scene.add(std::move(displaced));
    const NodeId node = scene.add_node(scene.root(), {.matrix = moved(2, 0, 0), .cages = {cage}});
    EXPECT_THROW(query.begin(kCamera), Error);
    scene.remove(node);
    scene.remove(cage);
    scene.remove(texture);
    ASSERT_NO_THROW(query.begin(kCamera));
    EXPECT_TRUE(query.closest(Vec3d(0.5, 0.5, 3), Vec3d(0, 0, -1)).has_value());
}

}  // namespace
}  // namespace occam
