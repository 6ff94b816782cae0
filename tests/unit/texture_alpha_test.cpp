// Tests of textures by which a material is cut out: what lies under their transparent texels is seen nowhere.
#include <gtest/gtest.h>

#include <cmath>

#include "io/texture/texture_store.h"
#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

constexpr int kLeafSide = 64;

// Opaque texels are orange and transparent ones black, in a pattern that is not even at any scale.
Texture leaves()
{
    Texture texture;
    texture.width = texture.height = kLeafSide;
    for (int y = 0; y < kLeafSide; ++y)
        for (int x = 0; x < kLeafSide; ++x)
            texture.pixels.push_back((x * x + 3 * y) % 7 < 3 ? Vec4f(1, 0.5f, 0.25f, 1) : Vec4f(0));
    return texture;
}

Material cut_out(TextureId texture, AlphaMode mode, float cutoff = 0.5f)
{
    Material material;
    material.base_color_texture.texture = texture;
    material.alpha_mode = mode;
    material.alpha_cutoff = cutoff;
    return material;
}

struct Sampled {
    float worst_color = 0, least_alpha = 1;  // how far a colour is from orange, where alpha is not 0
};

Sampled sampled(const TextureStore& store, TextureId texture)
{
    TextureUse use;
    use.texture = texture;
    Sampled found;
    for (const float width : {0.0f, 1.0f / kLeafSide, 0.05f, 0.2f, 0.7f})
        for (int k = 0; k < 200; ++k) {
            const Vec4f texel = store.sample(use, Vec2f(std::fmod(0.37f * float(k), 1.0f), float(k) / 200), width);
            found.least_alpha = std::min(found.least_alpha, texel.w);
            if (!(texel.w > 1e-3f)) continue;
            for (int c = 0; c < 3; ++c)
                found.worst_color = std::max(found.worst_color, std::abs(texel[c] - Vec3f(1, 0.5f, 0.25f)[c]));
        }
    return found;
}

TEST(CutOuts, KeepTheColourOfTheirOpaqueTexelsAtEveryWidth)
{
    Scene scene;
    const TextureId texture = scene.add(leaves());
    const MaterialId material = scene.add(cut_out(texture, AlphaMode::Opaque));
    TextureStore store(std::size_t(1) << 24);
    // Half floats of colours and of alpha are rounded by 2^-11 of themselves, at each level.
    const float rounded = 8 * 0x1p-11f;
    for (const AlphaMode mode : {AlphaMode::Mask, AlphaMode::Opaque, AlphaMode::Blend}) {
        scene.replace(material, cut_out(texture, mode));
        store.prepare(scene);
        const Sampled found = sampled(store, texture);
        EXPECT_LT(found.least_alpha, 0.5f);
        if (mode == AlphaMode::Opaque) EXPECT_GT(found.worst_color, 0.4f) << "its alpha has no say";
        else EXPECT_LT(found.worst_color, rounded);
    }
}

// A mask that shows everything shows the texels of no alpha, too.
TEST(CutOuts, AreThoseThatHideSomething)
{
    Scene scene;
    const TextureId texture = scene.add(leaves()), other = scene.add(leaves());
    const MaterialId material = scene.add(cut_out(texture, AlphaMode::Mask, 0));
    EXPECT_FALSE(scene.is_cut_out_by(texture));
    scene.replace(material, cut_out(texture, AlphaMode::Mask, 0.1f));
    EXPECT_TRUE(scene.is_cut_out_by(texture));
    EXPECT_FALSE(scene.is_cut_out_by(other));
    Material emits = cut_out(other, AlphaMode::Blend);
    emits.emission_texture.texture = texture;
    scene.replace(material, emits);
    EXPECT_FALSE(scene.is_cut_out_by(texture)) << "its alpha cuts nothing";
    EXPECT_TRUE(scene.is_cut_out_by(other));
    Material shows_all;
    shows_all.base_color_texture.texture = other;
    const MaterialId second = scene.add(shows_all);
    EXPECT_FALSE(scene.is_cut_out_by(other)) << "a part of it is seen whatever its alpha";
    scene.remove(second);
    EXPECT_TRUE(scene.is_cut_out_by(other));
    scene.environment.image = other;
    EXPECT_FALSE(scene.is_cut_out_by(other));
}

// A leaf is as bright in few pixels as in many.
TEST(CutOuts, AreAsBrightInSmallPictures)
{
    Scene scene;
    Material leaf = cut_out(scene.add(leaves()), AlphaMode::Blend);
    leaf.unlit = true;
    Cage square = test::textured_square();
    square.materials = {scene.add(leaf)};
    scene.add_node(scene.root(), {.cages = {scene.add(square)}});
    const Camera camera = Camera::look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.4f);
    for (const int side : {2, 8, 64}) {
        const Settings settings{.width = side, .height = side, .spp = 4, .background = false};
        const Image image = Renderer({.threads = 1}).render(scene, camera, settings);
        const std::vector<float>& pixels = image.layers().front().pixels;
        int seen = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 4) {
            if (!(pixels[i + 3] > 0.05f)) continue;
            ++seen;
            EXPECT_NEAR(pixels[i] / pixels[i + 3], 1, 0.01f) << side;
            EXPECT_NEAR(pixels[i + 2] / pixels[i + 3], 0.25f, 0.003f) << side;
        }
        EXPECT_GE(seen, side * side / 4);
    }
}

}  // namespace
}  // namespace occam
