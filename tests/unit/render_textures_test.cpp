// Tests of pictures of textured surfaces: the same mapping gives the same picture however it is written, masks are as open
// far away as they are nearby, and textures cannot take light away.
#include <gtest/gtest.h>

#include <cmath>

#include "render/compare.h"
#include "tests/support/textured_floor.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

// Returns a floor whose coordinates are stretched and slanted, and then go through the transform of a use.
Cage slanted_floor(MaterialId material, Scheme scheme, const TextureUse& transform)
{
    Cage cage = floor_of(material, scheme);
    for (Vec2f& uv : cage.uv_sets[0].values)
        uv = scaled_and_rotated(transform, {3 * uv.x + 0.5f * uv.y, 0.8f * uv.y}) + transform.offset;
    return cage;
}

Image picture_of(const Material& material, Scene& scene, Cage cage, render::ShadeAt at)
{
    cage.materials = {scene.add(material)};
    const NodeId floor = place(scene, scene.add(std::move(cage)), {0, 0, 0});
    Renderer renderer({.threads = 1});
    Settings settings{.width = 48, .height = 36, .spp = 4};
    settings.aovs = {render::Aov::NormalMean, render::Aov::Albedo};
    settings.integrator = IntegratorKind::Direct;
    settings.shade_at = at;
    const Image image = renderer.render(scene, Camera::look_at({0, 2.5, 3}, {0, 0, 0}, {0, 1, 0}, 0.9f), settings);
    scene.remove(floor);
    return image;
}

constexpr float kScales[][2] = {{1, 1}, {2, 0.5f}, {-3, 1}, {0.7f, -2}, {-1, -1.5f}};

// The axes of a normal map are those of the coordinates in the end, whether a file stores these or a transform.
TEST(TexturedSurfaces, NormalMapsFollowTransformsAsTheyFollowCoordinates)
{
    for (const Scheme scheme : {Scheme::Triangles, Scheme::CatmullClark})
        for (const auto& scale : kScales)
            for (const float rotation : {0.0f, 0.6f, -2.1f}) {
                TextureUse transform;
                transform.offset = {0.1f, 0.2f};
                transform.scale = {scale[0], scale[1]};
                transform.rotation = rotation;
                Scene scene;
                scene.environment.radiance = Vec3f(1);
                Material material;
                material.normal_texture.texture = scene.add(
                    texture_of([](float, float) { return Vec4f(0.8f, 0.6f, 0.85f, 1); }));
                const Image baked = picture_of(material, scene, slanted_floor({}, scheme, transform), render::ShadeAt::Hit);
                const TextureId map = material.normal_texture.texture;
                material.normal_texture = transform;
                material.normal_texture.texture = map;
                for (const render::ShadeAt at : {render::ShadeAt::Hit, render::ShadeAt::Vertex}) {
                    const Image moved = picture_of(material, scene, slanted_floor({}, scheme, {}), at);
                    EXPECT_LT(render::compare(moved, baked, "normal_mean").max, 2e-3)
                        << rotation << ' ' << scale[0] << ' ' << scale[1] << ' ' << int(scheme);
                }
            }
}

// The floor has as many texels a length one way as the other, by its coordinates, the transform or the image's own size.
TEST(TexturedSurfaces, AreAsSharpHoweverTheTexelsAreSpreadOverThem)
{
    const auto stripes = [](int width, int height) {
        Texture texture;
        texture.role = TextureRole::Data;
        texture.width = width, texture.height = height;
        for (int k = 0; k < width * height; ++k) texture.pixels.push_back(Vec4f(Vec3f(k % 4 < 2 ? 0.1f : 0.9f), 1));
        return texture;
    };
    const auto floor_with = [](float repeats) {
        Cage cage = floor_of({}, Scheme::Triangles);
        for (Vec2f& uv : cage.uv_sets[0].values) uv.x *= repeats;
        for (Vec3f& p : cage.positions) p.x *= 8;
        return cage;
    };
    Scene scene;
    scene.environment.radiance = Vec3f(1);
    Material material;
    material.base_color_texture.texture = scene.add(stripes(64, 64));
    const Image by_coordinates = picture_of(material, scene, floor_with(8), render::ShadeAt::Hit);
    material.base_color_texture.scale = {8, 1};
    const Image by_transform = picture_of(material, scene, floor_with(1), render::ShadeAt::Hit);
    EXPECT_LT(render::compare(by_transform, by_coordinates, "albedo").rmse, 1e-4);
    material.base_color_texture.scale = {1, 1};
    material.base_color_texture.texture = scene.add(stripes(512, 64));
    const Image by_size = picture_of(material, scene, floor_with(1), render::ShadeAt::Hit);
    EXPECT_LT(render::compare(by_size, by_coordinates, "albedo").rmse, 1e-4);
}

double covered_share(const Image& image)
{
    double sum = 0;
    for (std::size_t i = 3; i < image.layers()[0].pixels.size(); i += 4) sum += double(image.layers()[0].pixels[i]);
    return sum;
}

// Three eighths of a mask are there. Its texels are far smaller than pixels.
TEST(TexturedSurfaces, MasksAreAsOpenFarAwayAsNearby)
{
    for (const Scheme scheme : {Scheme::Triangles, Scheme::CatmullClark})
        for (const bool is_apart : {false, true}) {
            TexturedFloor world(scheme, [](Scene&) { return Material(); });
            const double whole = covered_share(world.picture({}));
            Material mask;
            mask.alpha_mode = AlphaMode::Mask;
            TextureUse& use = is_apart ? mask.alpha_texture : mask.base_color_texture;
            use.texture = world.scene.add(texture_of([](float x, float) {
                const float is_there = int(x) % 8 < 3 ? 1.0f : 0.0f;
                return Vec4f(is_there, 1, 1, is_there);
            }));
            use.scale = Vec2f(100);
            place(world.scene, world.scene.add(floor_of(world.scene.add(mask), scheme)), {0, 0, 0});
            const std::vector<NodeId> below = world.scene.node(world.scene.root()).children;
            world.scene.set_visible(below.front(), false);
            EXPECT_NEAR(covered_share(world.picture({})) / whole, 0.375, 0.02) << int(scheme) << ' ' << is_apart;
        }
}

TEST(TexturedSurfaces, TexelsBelowZeroTakeNoLightAway)
{
    for (const bool is_emission : {false, true}) {
        TexturedFloor world(Scheme::Triangles, [&](Scene& scene) {
            Material m;
            if (is_emission) m.emission = Vec3f(1);
            (is_emission ? m.emission_texture : m.base_color_texture).texture = scene.add(
                texture_of([](float, float) { return Vec4f(-3, -0.5f, 0.5f, 1); }));
            return m;
        });
        const Image image = world.picture({});
        for (const float value : image.layers()[0].pixels) ASSERT_GE(value, 0);
        EXPECT_GT(covered_share(image), 100);
    }
}

// A query finds what the picture shows.
TEST(TexturedSurfaces, QueriesPassTheHolesOfMasks)
{
    Scene scene;
    Material mask;
    mask.alpha_mode = AlphaMode::Mask;
    mask.base_color_texture.nearest = true;
    mask.base_color_texture.texture = scene.add(
        texture_of([](float x, float) { return Vec4f(1, 1, 1, x < kTexels / 2 ? 1.0f : 0.0f); }));
    const NodeId sheet = place(scene, scene.add(floor_of(scene.add(mask), Scheme::Triangles)), {0, 1, 0});
    const NodeId floor = place(scene, scene.add(floor_of(scene.add(Material{}), Scheme::Triangles)), {0, 0, 0});
    const Query query(scene, Camera::look_at({0, 5, 0.1}, {0, 0, 0}, {0, 1, 0}, 0.9f));
    const auto left = query.closest({-1, 3, 0}, {0, -1, 0}), right = query.closest({1, 3, 0}, {0, -1, 0});
    ASSERT_TRUE(left && right);
    EXPECT_EQ(left->node, sheet);
    EXPECT_EQ(right->node, floor);
    EXPECT_TRUE(query.is_occluded({-1, 3, 0}, {-1, 0.5, 0}));
    EXPECT_FALSE(query.is_occluded({1, 3, 0}, {1, 0.5, 0}));
}

}  // namespace
}  // namespace occam::test
