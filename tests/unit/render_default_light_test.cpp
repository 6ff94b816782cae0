// Which scenes get the default light because their emissive surfaces do not light what the camera sees.
#include <gtest/gtest.h>

#include <cmath>

#include "occam/occam.h"

namespace occam {
namespace {

// Adds a horizontal square about `middle`.
void add_square(Scene& scene, Vec3f middle, float half, Vec3f color, float emission)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (const Vec2f corner : {Vec2f(-1, -1), Vec2f(-1, 1), Vec2f(1, 1), Vec2f(1, -1)})
        cage.positions.push_back(middle + Vec3f(corner.x * half, 0, corner.y * half));
    cage.face_vertices = {0, 1, 2, 0, 2, 3};
    Material material;
    material.base_color = Vec4f(color, 1);
    material.metallic = 0;
    material.emission = Vec3f(emission);
    cage.materials = {scene.add(material)};
    NodeDesc node;
    node.cages = {scene.add(std::move(cage))};
    scene.add_node(scene.root(), node);
}

// Makes a node's square a cage, whose light rays find by chance alone.
void make_cage(Scene& scene, NodeId node)
{
    const CageId id = scene.node(node).cages.front();
    Cage cage = scene.cage(id).cage;
    cage.scheme = Scheme::Bilinear;
    cage.face_vertices = {0, 1, 2, 3};
    cage.face_sizes = {4};
    scene.replace(id, std::move(cage));
}

struct Seen {
    bool has_default;
    float middle;  // red in the middle of the picture
};

Seen render(Scene& scene, Vec3d eye, Settings settings = {})
{
    settings.width = settings.height = 33;
    settings.spp = 16;
    Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
    const Image image = renderer.render(scene, Camera::look_at(eye, {0, 0.2, 0}, {0, 0, -1}, 0.6f), settings);
    return {renderer.stats().lights.has_default, image.find("beauty")->pixels[4 * (33 * 16 + 16)]};
}

// The floor has more than enough power, but all its light meets the plate from below.
TEST(DefaultLight, StaysWhereAGlowingFloorLeavesWhatIsSeenBlack)
{
    for (const float floor : {6.0f, 120.0f}) {
        Scene scene;
        add_square(scene, {0, 0, 0}, floor, Vec3f(0.5f), 0.5f);
        add_square(scene, {0, 0.2f, 0}, 1, Vec3f(0.8f), 0);
        const Seen seen = render(scene, {0, 2.5 * double(floor), 0});
        EXPECT_TRUE(seen.has_default) << floor;
        EXPECT_GT(seen.middle, 0.1f) << floor;
        Settings none;
        none.sky = shade::Sky::Off;
        EXPECT_FALSE(render(scene, {0, 15, 0}, none).has_default);
    }
}

TEST(DefaultLight, StaysAwayWhereALampLightsWhatIsSeen)
{
    Scene scene;
    add_square(scene, {0, 0, 0}, 3, Vec3f(0.8f), 0);
    add_square(scene, {0, 2, 2.5f}, 0.7f, Vec3f(0), 5);
    const Seen seen = render(scene, {0, 9, 0.01});
    EXPECT_FALSE(seen.has_default);
    EXPECT_GT(seen.middle, 0.02f);
    EXPECT_LT(seen.middle, 1.0f);
}

// Surfaces that move, and cages, are not sampled: rays find them by chance, and few of the samples of a pixel do.
TEST(DefaultLight, StaysAwayWhereTheLampMovesOrIsACage)
{
    for (const bool moves : {true, false}) {
        Scene scene;
        add_square(scene, {0, 0, 0}, 3, Vec3f(0.8f), 0);
        add_square(scene, {0, 2, 2.5f}, 0.7f, Vec3f(0), 5);
        const NodeId lamp = scene.node(scene.root()).children.back();
        if (moves) {
            scene.record_shutter(1, [&](double tau) { scene.set_transform(lamp, Trs{.translation = {1e-4 * tau, 0, 0}}); });
        } else {
            make_cage(scene, lamp);
        }
        EXPECT_FALSE(render(scene, {0, 9, 0.01}).has_default) << moves;
    }
}

// Pictures of several seeds may be averaged, so the seed has no say. A wall hides the lamp from more of the floor the nearer
// it stands.
TEST(DefaultLight, DoesNotDependOnTheSeed)
{
    int with = 0, scenes = 0;
    for (double wall = -2; wall < 1; wall += 0.4, ++scenes) {
        Scene scene;
        const auto add_upright = [&](Vec3d at, float half, float color, float emission) {
            add_square(scene, Vec3f(0), half, Vec3f(color), emission);
            Trs place;
            place.translation = at;
            place.rotation = {0, 0, -std::sqrt(0.5), std::sqrt(0.5)};  // it faces +x
            scene.set_transform(scene.node(scene.root()).children.back(), place);
        };
        add_square(scene, {0, 0, 0}, 6, Vec3f(0.8f), 0);
        add_upright({-4, 1.2, 0}, 1, 0, 3);
        make_cage(scene, scene.node(scene.root()).children.back());
        add_upright({wall, 0, 0}, 5, 0.8f, 0);
        const auto has_default = [&](std::uint64_t seed) {
            Settings settings{.width = 32, .height = 24, .spp = 1};
            settings.bounces = 0;
            settings.seed = seed;
            Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
            renderer.render(scene, Camera::look_at({0, 5, 12}, {0, 0, 0}, {0, 1, 0}, 0.7f), settings);
            return renderer.stats().lights.has_default;
        };
        const bool first = has_default(0);
        with += first;
        for (std::uint64_t seed = 1; seed < 8; ++seed) EXPECT_EQ(has_default(seed), first) << wall << ' ' << seed;
    }
    EXPECT_GT(with, 0);
    EXPECT_LT(with, scenes);
}

TEST(DefaultLight, IsForcedOrForbiddenBySettings)
{
    Scene scene;
    add_square(scene, {0, 0, 0}, 3, Vec3f(0.8f), 0);
    add_square(scene, {0, 2, 2.5f}, 0.7f, Vec3f(0), 5);
    Settings settings;
    settings.default_light = true;
    EXPECT_TRUE(render(scene, {0, 9, 0.01}, settings).has_default);
    settings.default_light = false;
    EXPECT_FALSE(render(scene, {0, 9, 0.01}, settings).has_default);
}

// The measure is the whole frame's, whatever part of it is rendered.
TEST(DefaultLight, IsTheSameForEachCrop)
{
    Scene scene;
    add_square(scene, {0, 0, 0}, 6, Vec3f(0.5f), 0.5f);
    add_square(scene, {0, 0.2f, 0}, 1, Vec3f(0.8f), 0);
    Settings corner;
    corner.crop_x1 = corner.crop_y1 = 0.25f;
    corner.width = corner.height = 32;
    corner.spp = 1;
    Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
    renderer.render(scene, Camera::look_at({0, 15, 0}, {0, 0, 0}, {0, 0, -1}, 0.6f), corner);
    EXPECT_TRUE(renderer.stats().lights.has_default);
}

// The mirror reflects the middle of the key light's disc, which has the tangent 0.05, towards the eye.
TEST(DefaultLight, AMirrorShowsTheDiscOfTheLamp)
{
    const Vec3f to_eye(0, 0, 1), to_lamp = -glm::normalize(Vec3f(0.5f, -0.8f, -0.6f));
    const Vec3f normal = glm::normalize(to_eye + to_lamp), x = glm::normalize(glm::cross(Vec3f(0, 1, 0), normal)),
                y = glm::cross(normal, x);
    for (const float roughness : {0.0f, 0.02f}) {
        Scene scene;
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {-x - y, x - y, x + y, y - x};
        cage.face_vertices = {0, 1, 2, 0, 2, 3};
        Material chrome;
        chrome.base_color = Vec4f(1);
        chrome.metallic = 1;
        chrome.roughness = roughness;
        cage.materials = {scene.add(chrome)};
        NodeDesc node;
        node.cages = {scene.add(std::move(cage))};
        scene.add_node(scene.root(), node);
        Settings settings;
        settings.width = settings.height = 8;
        settings.spp = 16;
        settings.bounces = 0;
        Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
        const Image image = renderer.render(scene, Camera::look_at({0, 0, 50}, Vec3d(0), {0, 1, 0}, 0.004f), settings);
        const double disc = 1.6 / (3.14159265 * 0.05 * 0.05);
        double mean = 0;
        for (std::size_t pixel = 0; pixel < 64; ++pixel) {
            const double radiance = double(image.find("beauty")->pixels[4 * pixel]);
            mean += radiance / 64;
            EXPECT_NEAR(radiance, disc, 0.2 * disc) << roughness;  // a single scattered ray in thousands misses the disc
        }
        EXPECT_NEAR(mean, disc, 0.01 * disc) << roughness;
    }
}

}  // namespace
}  // namespace occam
