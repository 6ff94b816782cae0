// Tests that excessive values in a file are clamped, and counted in a warning.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <limits>

#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity(), kNaN = std::numeric_limits<float>::quiet_NaN();

struct Picture {
    float brightest = 0;
    bool is_finite = true;
    std::vector<std::string> warnings;

    bool warns_of(const std::string& text) const
    {
        for (const std::string& line : warnings)
            if (line.find(text) != std::string::npos) return true;
        return false;
    }
};

Picture picture_of(Scene& scene)
{
    Renderer renderer({.threads = 1});
    const Image image = renderer.render(scene, Camera::framing(scene.bounds()), {.width = 24, .height = 16, .spp = 4});
    Picture out;
    for (const float value : image.find("beauty")->pixels) {
        out.is_finite &= std::isfinite(value);
        out.brightest = std::max(out.brightest, value);
    }
    EXPECT_EQ(renderer.stats().image.samples_not_finite, 0u);
    out.warnings = renderer.stats().warnings;
    return out;
}

Scene scene_of(const Material& material)
{
    Scene scene;
    Cage cage = torus();
    cage.materials = {scene.add(material)};
    place(scene, scene.add(std::move(cage)), Vec3d(0));
    return scene;
}

TEST(InputLimits, TexelsThatAreNotFiniteAreClampedAndCounted)
{
    Scene scene = scene_of({});
    Texture sky;
    sky.name = "sky";
    sky.width = 8;
    sky.height = 4;
    sky.pixels.assign(32, Vec4f(1));
    sky.pixels[3] = Vec4f(kInfinity, 1, 1, 1);
    sky.pixels[9] = Vec4f(kNaN);
    sky.pixels[20] = Vec4f(1, 1e30f, -kInfinity, 1);
    scene.environment = {Vec3f(1), scene.add(std::move(sky)), 0};
    const Picture p = picture_of(scene);
    EXPECT_TRUE(p.is_finite);
    EXPECT_TRUE(p.warns_of("sky: texels that are not finite numbers, or above 65504, were clamped: 3"));
}

TEST(InputLimits, StrengthsBeyondMeasureAreClampedAndCountedAndWhatIsNoNumberIsRefused)
{
    for (const float strength : {1e13f, 1e38f}) {
        Material glow;
        glow.emission = Vec3f(strength);
        Scene scene = scene_of(glow);
        NodeDesc lamp;
        lamp.place.translation = {0, 4, 0};
        lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(strength)}});
        scene.add_node(scene.root(), lamp);
        scene.environment.radiance = Vec3f(strength);
        const Picture p = picture_of(scene);
        EXPECT_TRUE(p.is_finite) << strength;
        EXPECT_TRUE(p.warns_of("brighter than 1e12, which were clamped: 3")) << strength;
    }
    for (const float radiance : {kInfinity, kNaN}) {
        Scene scene = scene_of({});
        scene.environment.radiance = Vec3f(radiance);
        EXPECT_THROW(picture_of(scene), Error) << radiance;
    }
    Scene scene = scene_of({});
    EXPECT_FALSE(picture_of(scene).warns_of("clamped"));
}

Texture floats_named(const char* name, const Vec4f& odd_texel)
{
    Texture image;
    image.name = name;
    image.width = 8;
    image.height = 4;
    image.pixels.assign(32, Vec4f(1));
    image.pixels[9] = image.pixels[17] = odd_texel;
    return image;
}

TEST(InputLimits, StrengthsWithinTheLimitWhoseImagesAreBrightAreCounted)
{
    for (const float texel : {2.0f, 60000.0f}) {
        Scene scene = scene_of({});
        Material glow;
        glow.emission = Vec3f(0, 1e11f, 0);
        glow.emission_texture.texture = scene.add(floats_named("glow", Vec4f(1, texel, 1, 1)));
        Cage square = textured_square();
        square.materials = {scene.add(glow)};
        place(scene, scene.add(std::move(square)), Vec3d(0, 2, 0));
        scene.environment = {Vec3f(0, 1e11f, 0), scene.add(floats_named("sky", Vec4f(1, texel, 1, 1))), 0};
        const Picture p = picture_of(scene);
        EXPECT_TRUE(p.is_finite) << texel;
        EXPECT_LE(p.brightest, 1e13f) << texel << ": one square scatters light of its own and of the sky";
        EXPECT_EQ(p.warns_of("brighter than 1e12, which were clamped: 2"), texel > 10);
        EXPECT_EQ(p.warns_of("which were clamped"), texel > 10);
    }
}

TEST(InputLimits, TexelsBelowZeroAreCountedWhereTheyAreColours)
{
    Scene scene = scene_of({});
    scene.environment = {Vec3f(1), scene.add(floats_named("sky", Vec4f(1, -0.25f, 1, 1))), 0};
    EXPECT_TRUE(picture_of(scene).warns_of("sky: texels with a colour below 0, which counts as 0: 2"));

    Material mapped;
    Texture slopes = floats_named("slopes", Vec4f(0.5f, 0.5f, -1, 1));
    slopes.role = TextureRole::Data;
    Scene bumpy;
    mapped.normal_texture.texture = bumpy.add(std::move(slopes));
    Cage square = textured_square();
    square.materials = {bumpy.add(mapped)};
    place(bumpy, bumpy.add(std::move(square)), Vec3d(0));
    EXPECT_FALSE(picture_of(bumpy).warns_of("below 0"));
}

TEST(InputLimits, NoSurfaceReflectsMoreLightThanItGets)
{
    for (const float metallic : {0.0f, 1.0f}) {
        Material bright;
        bright.base_color = Vec4f(50, 2, 1e30f, 1);
        bright.metallic = metallic;
        Scene scene = scene_of(bright);
        scene.environment.radiance = Vec3f(1);
        const Picture p = picture_of(scene);
        EXPECT_TRUE(p.is_finite);
        EXPECT_LT(p.brightest, 2) << "a sample may vary, the mean is 1";
        EXPECT_TRUE(p.warns_of("base colour is above 1, which reflect as if it were 1: 1"));
    }
}

// Each of these materials has one factor far beyond its limit, and lets the furnace of radiance 1 see no more than that.
TEST(InputLimits, FactorsBeyondTheirLimitsAreClampedAndCounted)
{
    constexpr float kHuge = 3e38f;
    const std::vector<std::pair<const char*, void (*)(Material&)>> cases{
        {"alpha", [](Material& m) { m.base_color.w = kHuge, m.alpha_mode = AlphaMode::Blend; }},
        {"sheen", [](Material& m) { m.sheen_color = Vec3f(kHuge), m.sheen_roughness = 0.5f; }},
        {"specular", [](Material& m) { m.specular_color = Vec3f(kHuge); }},
        {"ior", [](Material& m) { m.ior = kHuge; }},
        {"glass", [](Material& m) { m.ior = kHuge, m.transmission = 1, m.thickness = 1; }},
        {"attenuation",
         [](Material& m) {
             m.attenuation_color = Vec3f(kHuge), m.attenuation_distance = 1, m.transmission = 1, m.thickness = 1;
         }},
        {"normal", [](Material& m) { m.normal_scale = kHuge; }},
        {"coat", [](Material& m) { m.clearcoat = 1, m.clearcoat_normal_scale = -kHuge; }},
    };
    for (const auto& [name, set] : cases) {
        Material material;
        set(material);
        Scene scene = scene_of(material);
        Texture bumpy;
        bumpy.role = TextureRole::Data;
        bumpy.width = bumpy.height = 2;
        bumpy.pixels = {Vec4f(0.9f, 0.5f, 0.9f, 1), Vec4f(0.1f, 0.5f, 0.9f, 1), Vec4f(0.5f), Vec4f(0.5f, 0.9f, 0.8f, 1)};
        Material mapped = material;
        mapped.normal_texture.texture = mapped.clearcoat_normal_texture.texture = scene.add(std::move(bumpy));
        Cage square = textured_square();
        square.materials = {scene.add(mapped)};
        place(scene, scene.add(std::move(square)), Vec3d(0, 2, 0));
        scene.environment.radiance = Vec3f(1);
        const Picture p = picture_of(scene);
        EXPECT_TRUE(p.is_finite) << name;
        EXPECT_LT(p.brightest, 2) << name << ": a sample may vary, the mean is 1";
        EXPECT_TRUE(p.warns_of("which were clamped: 2")) << name;
    }
    Scene usual = scene_of({});
    EXPECT_FALSE(picture_of(usual).warns_of("clamped"));
}

TEST(InputLimits, TransformsOfTexturesBeyondMeasureAreCounted)
{
    for (const int field : {0, 1, 2})
        for (const float value : {1e7f, -3e38f}) {
            Scene scene;
            Material material;
            Texture image;
            image.width = image.height = 2;
            image.pixels.assign(4, Vec4f(0.5f));
            material.base_color_texture.texture = scene.add(std::move(image));
            if (field == 0) material.base_color_texture.offset.y = value;
            if (field == 1) material.base_color_texture.scale.x = value;
            if (field == 2) material.base_color_texture.rotation = value;
            Cage square = textured_square();
            square.materials = {scene.add(material)};
            place(scene, scene.add(std::move(square)), Vec3d(0));
            const Picture p = picture_of(scene);
            EXPECT_TRUE(p.is_finite) << field;
            EXPECT_TRUE(p.warns_of("in the transform of a texture, which tell no texel from another: 1")) << field << value;
        }
}

Mat4d of_size(double size)
{
    Mat4d m(size);
    m[3] = Vec4d(0, 0, 0, 1);
    return m;
}

constexpr const char* kVanishes = "nodes that reach beyond 1e16, beside which the rest of the scene vanishes: 1";
constexpr const char* kLost = "nodes whose place in the world is not finite, which are not seen: 1";

// Returns what a frame of a torus at the origin and of another one that is placed like this warns of, and the largest
// number of a surface that is seen: 0 if none is.
Picture beside(const Mat4d& far, const Mat4d& above = Mat4d(1))
{
    Scene scene = scene_of({});
    const NodeId parent = scene.add_node(scene.root(), {.matrix = above});
    scene.add_node(parent, {.matrix = far, .cages = {scene.add(torus())}});
    Renderer renderer({.threads = 1});
    const Image image = renderer.render(scene, Camera::look_at({0, 2, 4}, Vec3d(0), {0, 1, 0}, 0.8f),
                                        {.width = 24, .height = 16, .spp = 1, .aovs = Aov::Id});
    Picture out;
    for (const float value : image.find("id")->pixels) out.brightest = std::max(out.brightest, value);
    out.warnings = renderer.stats().warnings;
    return out;
}

TEST(InputLimits, NodesBesideWhichTheRestVanishesAreCounted)
{
    for (const double far : {1e25, 1e30, 1e300}) {
        const Picture p = beside(moved(far, 0, 0));
        EXPECT_TRUE(p.warns_of(kVanishes)) << far;
        EXPECT_EQ(p.brightest, 0) << "as the warning says";
        EXPECT_TRUE(beside(of_size(far)).warns_of(kVanishes)) << far;
    }
    for (const double far : {1.0, 1e16, 1e20}) {
        EXPECT_FALSE(beside(moved(far, 0, 0)).warns_of("nodes")) << far;
        EXPECT_FALSE(beside(of_size(far)).warns_of("nodes")) << far;
    }
    Scene alone;
    alone.add_node(alone.root(), {.matrix = of_size(1e30), .cages = {alone.add(torus())}});
    EXPECT_FALSE(picture_of(alone).warns_of("nodes")) << "there is nothing that could vanish";
}

TEST(InputLimits, WeightsOfMorphTargetsBesideWhichTheRestVanishesAreCounted)
{
    Scene scene = scene_of({});
    Cage cage = torus();
    cage.morph_targets.push_back({"up", std::vector<Vec3f>(cage.positions.size(), Vec3f(0, 1, 0)), {}});
    const NodeId node = place(scene, scene.add(std::move(cage)), Vec3d(0));
    scene.set_morph_weights(node, {1e15f});
    EXPECT_FALSE(picture_of(scene).warns_of("nodes"));
    scene.set_morph_weights(node, {1e30f});
    EXPECT_TRUE(picture_of(scene).warns_of(kVanishes));
}

TEST(InputLimits, NodesWhosePlaceIsNotFiniteAreCounted)
{
    for (const Mat4d& far : {of_size(1e200), moved(1e200, 0, 0), moved(1e200, 0, 0) * of_size(1e200)}) {
        const Picture p = beside(far, of_size(1e200));
        EXPECT_TRUE(p.warns_of(kLost));
        EXPECT_GT(p.brightest, 0) << "the rest is seen";
    }
    EXPECT_FALSE(beside(of_size(1e100), of_size(1e100)).warns_of(kLost));
}

}  // namespace
}  // namespace occam::test
