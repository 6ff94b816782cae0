// Placed lights are kept from frame to frame while they are the same, and what is kept changes no picture.
#include <gtest/gtest.h>

#include <vector>

#include "api/include/occam/occam.h"
#include "shade/placed_lights.h"

namespace occam::shade {
namespace {

// Point lights in a row; every third is a sun.
std::vector<WorldLight> row_of_lights(std::size_t count)
{
    std::vector<WorldLight> lights(count);
    for (std::size_t i = 0; i < count; ++i) {
        if (i % 3 == 0) lights[i].kind = WorldLight::Kind::Sun;
        lights[i].position = Vec3d(double(i), 2, 0);
        lights[i].strength = Vec3f(1 + float(i));
    }
    return lights;
}

KeptLights gathered(const std::vector<WorldLight>& lights, const KeptLights& last)
{
    LightGathering gathering(last);
    for (const WorldLight& light : lights) gathering.add(light);
    EXPECT_EQ(gathering.is_empty(), lights.empty());
    return gathering.finish();
}

// The strength tells lights apart.
std::vector<float> strengths(const PlacedLights& placed)
{
    std::vector<float> all;
    for (const WorldLight& light : placed.lights) all.push_back(light.strength.x);
    return all;
}

TEST(PlacedLights, AreKeptWhileTheyAreTheSame)
{
    const std::vector<WorldLight> lights = row_of_lights(40);
    const KeptLights first = gathered(lights, nullptr);
    EXPECT_EQ(first->outside_tree, 14u);
    EXPECT_FALSE(first->tree.is_empty());
    EXPECT_EQ(gathered(lights, first), first);
}

TEST(PlacedLights, AreMadeAnewAfterAnyChange)
{
    const std::vector<WorldLight> lights = row_of_lights(40);
    const KeptLights first = gathered(lights, nullptr);
    std::vector<std::vector<WorldLight>> others;
    for (const std::size_t at : {0, 1, 20, 39}) {
        others.push_back(lights);
        others.back()[at].strength.x += 0.5f;
        others.push_back(lights);
        others.back()[at].position.z = -0.0;
        others.push_back(lights);
        others.back().erase(others.back().begin() + std::ptrdiff_t(at));
        others.push_back(lights);
        others.back().insert(others.back().begin() + std::ptrdiff_t(at), lights[3]);
    }
    // So few that there is no tree, and suns stand among the rest.
    for (const std::size_t count : {0, 1, 5, 16, 17}) others.push_back(row_of_lights(count));
    others.push_back(row_of_lights(10));
    others.back().front().strength.x = 0.5f;
    for (const std::vector<WorldLight>& other : others) {
        const KeptLights after = gathered(other, first), anew = gathered(other, nullptr);
        EXPECT_NE(after, first);
        EXPECT_EQ(strengths(*after), strengths(*anew)) << other.size();
        EXPECT_EQ(after->outside_tree, anew->outside_tree);
        EXPECT_EQ(after->with_extent, anew->with_extent);
        EXPECT_EQ(after->tree.is_empty(), anew->tree.is_empty());
    }
}

// A renderer that has rendered other lights before renders the same picture as a new one.
TEST(PlacedLights, ChangeNoPictureByBeingKept)
{
    Scene scene;
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {{-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    NodeDesc ground;
    ground.cages = {scene.add(std::move(floor))};
    scene.add_node(scene.root(), std::move(ground));
    std::vector<NodeId> lamps;
    for (int i = 0; i < 40; ++i) {
        NodeDesc desc;
        desc.light = scene.add(Light{"", PointLight{Vec3f(1)}});
        desc.place.translation = Vec3d(i % 8 - 4, 1, i / 8 - 2);
        lamps.push_back(scene.add_node(scene.root(), std::move(desc)));
    }
    const Camera camera = Camera::look_at({0, 5, 9}, {0, 0, 0}, {0, 1, 0}, 0.7f);
    const Settings settings{.width = 24, .height = 16, .spp = 2, .integrator = IntegratorKind::Direct};
    Renderer renderer(Resources{.threads = 1});
    const std::uint64_t before = renderer.render(scene, camera, settings).checksum();
    EXPECT_EQ(renderer.render(scene, camera, settings).checksum(), before);
    Trs moved;
    moved.translation = Vec3d(0, 0.5, 3);
    scene.set_transform(lamps[17], moved);
    const std::uint64_t after = renderer.render(scene, camera, settings).checksum();
    EXPECT_NE(after, before);
    EXPECT_EQ(Renderer(Resources{.threads = 1}).render(scene, camera, settings).checksum(), after);
}

}  // namespace
}  // namespace occam::shade
