#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>

#include "base/error.h"
#include "base/half_lanes.h"
#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

Texture image(int width, int height, std::vector<Vec4f> pixels)
{
    Texture texture;
    texture.name = "test";
    texture.width = width, texture.height = height;
    texture.pixels = std::move(pixels);
    return texture;
}
// Returns a texture whose texel in row y and column x is (x, y, 0, 1).
Texture ramp(int width, int height)
{
    std::vector<Vec4f> pixels;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) pixels.emplace_back(x, y, 0, 1);
    return image(width, height, std::move(pixels));
}

struct Prepared {
    Scene scene;
    TextureStore store{std::size_t(1) << 30};
    TextureUse use;

    explicit Prepared(Texture texture)
    {
        use.texture = scene.add(std::move(texture));
        store.prepare(scene);
    }
    Vec4f at(float u, float v, float width = 0) const { return store.sample(use, {u, v}, width); }
};

TEST(Half, EveryFiniteHalfSurvivesARoundTrip)
{
    for (std::uint32_t h = 0; h < 0x10000; ++h) {
        if ((h & 0x7c00u) == 0x7c00u) continue;
        const float f = float_from_half(static_cast<std::uint16_t>(h));
        EXPECT_EQ(finite_half_from_float(f), h) << f;
    }
}

TEST(Half, RoundsToNearestAndStaysFinite)
{
    EXPECT_EQ(float_from_half(finite_half_from_float(1.0f + 1.0f / 2048)), 1.0f) << "a tie goes to the even one";
    EXPECT_EQ(float_from_half(finite_half_from_float(1.0f + 3.0f / 2048)), 1.0f + 2.0f / 1024);
    EXPECT_EQ(float_from_half(finite_half_from_float(1e9f)), 65504.0f);
    EXPECT_EQ(float_from_half(finite_half_from_float(-INFINITY)), -65504.0f);
    EXPECT_EQ(float_from_half(finite_half_from_float(NAN)), 0.0f);
    EXPECT_EQ(float_from_half(finite_half_from_float(65519.0f)), 65504.0f);
}

TEST(TextureStore, TexelCentresLieAtHalves)
{
    const Prepared p(ramp(4, 2));
    EXPECT_EQ(p.at(0.5f / 4, 0.5f / 2), Vec4f(0, 0, 0, 1)) << "the first row is at the top, v runs downwards";
    EXPECT_EQ(p.at(2.5f / 4, 1.5f / 2), Vec4f(2, 1, 0, 1));
    EXPECT_EQ(p.at(2.0f / 4, 1.0f / 2), Vec4f(1.5f, 0.5f, 0, 1));
}

TEST(TextureStore, WrapsAsTheSamplerSays)
{
    Prepared p(ramp(4, 1));
    const auto red = [&](float u) { return p.at(u, 0.5f).x; };
    EXPECT_EQ(red(1.125f), 0) << "repeat";
    EXPECT_EQ(red(-0.125f), 3);
    EXPECT_EQ(red(0.0f), 1.5f) << "between the last and the first";
    EXPECT_EQ(red(-7.0f - 0.125f), 3);
    p.use.wrap_s = TextureUse::Wrap::Clamp;
    EXPECT_EQ(red(-3.0f), 0);
    EXPECT_EQ(red(9.0f), 3);
    p.use.wrap_s = TextureUse::Wrap::Mirror;
    EXPECT_EQ(red(1.125f), 3);
    EXPECT_EQ(red(-0.125f), 0);
    EXPECT_EQ(red(1.0f), 3);
    EXPECT_EQ(red(2.0f), 0);
    EXPECT_EQ(red(2.375f), 1);
}

TEST(TextureStore, NearestTakesOneTexel)
{
    Prepared p(ramp(4, 1));
    p.use.nearest = true;
    EXPECT_EQ(p.at(0.49f, 0.5f).x, 1);
    EXPECT_EQ(p.at(0.51f, 0.5f).x, 2);
    EXPECT_EQ(p.at(1.0f, 0.5f).x, 0);
}

// The sample viewer of the glTF working group applies the scale, then the rotation, then the offset.
TEST(TextureStore, MovesCoordinatesAsKhrTextureTransformSays)
{
    Prepared p(ramp(8, 8));
    p.use.nearest = true;
    p.use.offset = {0.25f, 0.5f};
    EXPECT_EQ(p.at(0.0625f, 0.0625f), Vec4f(2, 4, 0, 1));
    p.use = {.texture = p.use.texture, .scale = {2, 3}, .nearest = true};
    EXPECT_EQ(p.at(0.15f, 0.1f), Vec4f(2, 2, 0, 1));
    // After a quarter turn (u, v) looks up (v, -u).
    p.use = {.texture = p.use.texture, .rotation = 1.57079633f, .nearest = true};
    EXPECT_EQ(p.at(0.0625f, 0.3125f), Vec4f(2, 7, 0, 1));
}

TEST(TextureStore, AWideFilterGivesTheMean)
{
    // With an odd size the box filter has to weigh three texels.
    const Prepared p(ramp(13, 6));
    for (float width : {1.0f, 5.0f, INFINITY}) {
        const Vec4f mean = p.at(0.3f, 0.9f, width);
        EXPECT_NEAR(mean.x, 6.0f, 6.0f / 512);  // half floats were rounded at three levels
        EXPECT_NEAR(mean.y, 2.5f, 2.5f / 512);
    }
}

// A row of texels that a transform turns by a quarter lies along v, and its filter is as wide as along v.
TEST(TextureStore, FiltersARowThatIsTurnedAsOneThatIsNot)
{
    for (const bool is_row : {true, false}) {
        Scene scene;
        Texture texture;
        texture.width = is_row ? 256 : 1;
        texture.height = is_row ? 1 : 256;
        for (int i = 0; i < 256; ++i) texture.pixels.push_back(Vec4f(Vec3f(i % 2 ? 1.0f : 0.0f), 1));
        const TextureId id = scene.add(std::move(texture));
        TextureStore textures(std::size_t(1) << 24);
        textures.prepare(scene);
        for (const Vec2f scale : {Vec2f(1, 16), Vec2f(16, 1)}) {
            TextureUse turned, baked;
            turned.texture = baked.texture = id;
            turned.scale = scale;
            turned.rotation = 1.57079633f;  // s runs along v, and t against u
            baked.scale = {scale.y, -scale.x};
            for (const float width : {0.5f / 256, 2.0f / 256})
                for (int k = 0; k < 20; ++k) {
                    const Vec2f uv(0.3f + 0.00063f * float(k), 0.2f + 0.00071f * float(k));
                    EXPECT_NEAR(textures.sample(turned, uv, width).x, textures.sample(baked, {uv.y, uv.x}, width).x, 2e-3f)
                        << scale.x << ' ' << width << ' ' << k;
                }
        }
    }
}

TEST(TextureStore, LevelsBlendWithoutAJump)
{
    const Prepared p(ramp(64, 64));
    Vec4f last = p.at(0.37f, 0.41f, 1e-4f);
    for (float width = 1e-4f; width < 2; width *= 1.01f) {
        const Vec4f now = p.at(0.37f, 0.41f, width);
        EXPECT_LT(std::abs(now.x - last.x), 0.5f) << width;
        last = now;
    }
}

TEST(TextureStore, CoordinatesThatAreNoNumbersGiveNumbers)
{
    const Prepared p(ramp(5, 3));
    for (float bad : {NAN, INFINITY, -INFINITY, 1e38f, -1e38f, 1e-45f})
        for (float width : {0.0f, 0.3f, float(NAN), float(INFINITY), -1.0f}) {
            const Vec4f texel = p.at(bad, bad, width);
            for (int c = 0; c < 4; ++c) EXPECT_TRUE(std::isfinite(texel[c])) << bad << ' ' << width;
        }
}

// libpng leaves OpenImageIO's reader by a jump where the bytes end, and the reader's memory would leak.
TEST(TextureStore, APngThatIsCutOffAnywhereIsToldOfBeforeItIsDecoded)
{
    test::TempFolder folder;
    const std::filesystem::path path = folder.path() / "image.png";
    const auto writer = OIIO::ImageOutput::create(path.string());
    ASSERT_TRUE(writer && writer->open(path.string(), OIIO::ImageSpec(4, 4, 4, OIIO::TypeDesc::UINT8)));
    const std::vector<unsigned char> pixels(4 * 4 * 4, 77);
    ASSERT_TRUE(writer->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    writer->close();
    std::ifstream stream(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t size = 8; size <= bytes.size(); ++size) {
        Texture in_memory, in_file;
        const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
        in_memory.encoded = std::make_shared<const std::vector<std::byte>>(first, first + size);
        in_file.path = folder.write("cut.png", std::string_view(bytes).substr(0, size));
        for (Texture* texture : {&in_memory, &in_file}) {
            Scene scene;
            scene.add(*texture);
            TextureStore store(1 << 20);
            store.prepare(scene);
            store.decode_all();
            const std::vector<std::string> errors = store.errors();
            ASSERT_EQ(errors.empty(), size == bytes.size()) << size;
            for (const std::string& line : errors) EXPECT_NE(line.find("cut off"), std::string::npos) << line;
        }
    }
}

TEST(TextureStore, WhatIsNotThereIsGreyWithAWarningAndWhatCannotBeReadIsAnError)
{
    test::TempFolder folder;
    Scene scene;
    TextureStore store(1 << 20);
    EXPECT_EQ(store.sample({}, {0, 0}, 0), Vec4f(1));
    Texture missing, broken;
    missing.path = folder.path() / "missing.png";
    broken.path = folder.write("broken.png", "\x89PNG nonsense");
    TextureUse a, b;
    a.texture = scene.add(std::move(missing));
    b.texture = scene.add(std::move(broken));
    store.prepare(scene);
    store.decode_all();
    ASSERT_EQ(store.warnings().size(), 1u);
    EXPECT_NE(store.warnings()[0].find("missing.png: there is no such image file"), std::string::npos);
    ASSERT_EQ(store.errors().size(), 1u);
    EXPECT_NE(store.errors()[0].find("broken.png"), std::string::npos) << store.errors()[0];
    EXPECT_EQ(store.sample(a, {0.05f, 0.05f}, 0), Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_EQ(store.bytes(), 0u);
}

// As in a GLB, the bytes decide the format, since a declared type may be wrong.
TEST(TextureStore, AnImageInMemoryIsTheSameAsTheFile)
{
    test::TempFolder folder;
    constexpr int kSide = 16;
    std::vector<unsigned char> pixels;
    for (int i = 0; i < kSide * kSide; ++i)
        for (const int channel : {i, 255 - i, 40 + i / 2}) pixels.push_back(static_cast<unsigned char>(channel));
    for (const char* extension : {"png", "jpg", "tif", "bmp", "exr", "hdr"}) {
        const std::filesystem::path path = folder.path() / (std::string("image.") + extension);
        const auto writer = OIIO::ImageOutput::create(path.string());
        ASSERT_TRUE(writer) << extension;
        ASSERT_TRUE(writer->open(path.string(), OIIO::ImageSpec(kSide, kSide, 3, OIIO::TypeDesc::UINT8))) << extension;
        ASSERT_TRUE(writer->write_image(OIIO::TypeDesc::UINT8, pixels.data())) << extension;
        writer->close();
        std::ifstream stream(path, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(stream), {}};

        Scene scene;
        TextureUse of_file, of_memory;
        Texture texture;
        texture.path = path;
        of_file.texture = scene.add(std::move(texture));
        texture = {};
        const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
        texture.encoded = std::make_shared<const std::vector<std::byte>>(first, first + bytes.size());
        of_memory.texture = scene.add(std::move(texture));
        TextureStore store(1 << 20);
        store.prepare(scene);
        ASSERT_TRUE(store.warnings().empty()) << extension << ": " << store.warnings()[0];
        for (int i = 0; i < kSide * kSide; ++i) {
            const Vec2f uv = (Vec2f(i % kSide, i / kSide) + 0.5f) / static_cast<float>(kSide);
            ASSERT_EQ(store.sample(of_memory, uv, 0), store.sample(of_file, uv, 0)) << extension << ' ' << i;
        }
    }
}

// In a PPM of 8 bits, colours are sRGB and data is linear.
TEST(TextureStore, MakesColoursLinearAndLeavesDataAlone)
{
    test::TempFolder folder;
    const std::string_view bytes("P6\n2 1\n255\n\xff\x80\0\x10\x20\x40", 17);
    Scene scene;
    TextureUse color, data;
    Texture texture;
    texture.path = folder.write("two.ppm", bytes);
    color.texture = scene.add(texture);
    texture.role = TextureRole::Data;
    data.texture = scene.add(texture);
    TextureStore store(1 << 20);
    store.prepare(scene);
    ASSERT_TRUE(store.warnings().empty()) << store.warnings()[0];
    EXPECT_NEAR(store.sample(color, {0.25f, 0.5f}, 0).y, 0.21586f, 1e-4f);
    EXPECT_NEAR(store.sample(data, {0.25f, 0.5f}, 0).y, 128.0f / 255, 3e-4f);
    EXPECT_EQ(store.sample(color, {0.25f, 0.5f}, 0).x, 1.0f);
    EXPECT_EQ(store.sample(color, {0.25f, 0.5f}, 0).w, 1.0f);
}

TEST(TextureStore, StaysWithinItsCapByHalvingTheLargest)
{
    Scene scene;
    TextureUse large, small;
    large.texture = scene.add(ramp(256, 256));
    small.texture = scene.add(ramp(16, 16));
    TextureStore store(300'000);  // the large one takes about 700 KB with its levels
    store.prepare(scene);
    store.decode_all();
    EXPECT_LE(store.bytes(), 300'000u);
    EXPECT_EQ(store.warnings().size(), 1u);
    EXPECT_NEAR(store.sample(large, {0.5f, 0.5f}, 0).x, 127.5f, 0.5f);
    EXPECT_EQ(store.sample(small, {0.5f / 16, 0.5f / 16}, 0), Vec4f(0, 0, 0, 1)) << "the small one is whole";
}

TEST(TextureStore, HalvesAsANewStoreDoesWhateverItKnew)
{
    Scene scene;
    TextureUse uses[3];
    TextureStore kept(1'000'000);  // each takes about 700 KB with its levels
    for (TextureUse& use : uses) {
        use.texture = scene.add(ramp(256, 256));
        kept.prepare(scene);
        kept.decode_all();
        TextureStore fresh(1'000'000);
        fresh.prepare(scene);
        fresh.decode_all();
        EXPECT_LE(kept.bytes(), 1'000'000u);
        EXPECT_EQ(kept.bytes(), fresh.bytes());
        EXPECT_EQ(kept.warnings(), fresh.warnings());
        for (const TextureUse& known : uses) EXPECT_EQ(kept.texel_width(known), fresh.texel_width(known));
    }
}

TEST(Half, ManyAtOnceHaveTheSameBitsAsEachAlone)
{
    std::vector<float> floats;
    for (std::uint32_t bits = 0; bits < 0xffff0000u; bits += 0x1237u) floats.push_back(std::bit_cast<float>(bits));
    std::vector<std::uint16_t> halves(floats.size());
    finite_halves_from_floats(floats.data(), floats.size(), halves.data());
    for (std::size_t i = 0; i < floats.size(); ++i) ASSERT_EQ(halves[i], finite_half_from_float(floats[i])) << floats[i];
}

TEST(TextureStore, DecodesOnlyWhatIsLookedUp)
{
    Scene scene;
    TextureUse first, second;
    first.texture = scene.add(ramp(64, 64));
    second.texture = scene.add(ramp(128, 128));
    TextureStore store(1 << 24);
    store.prepare(scene);
    EXPECT_EQ(store.bytes(), 0u);
    store.sample(first, {0.5f, 0.5f}, 0);
    const std::size_t one = store.bytes();
    EXPECT_GT(one, 0u);
    store.decode_all();
    EXPECT_GT(store.bytes(), 4 * one);
}

TEST(TextureStore, ManyThreadsMayAskFirst)
{
    Prepared p(ramp(256, 256));
    std::vector<std::jthread> threads;
    std::atomic<int> wrong{0};
    for (int t = 0; t < 4; ++t) threads.emplace_back([&] { wrong += p.at(0.5f / 256, 0.5f / 256) != Vec4f(0, 0, 0, 1); });
    threads.clear();
    EXPECT_EQ(wrong, 0);
}

TEST(TextureStore, ASecondPrepareKeepsWhatItHas)
{
    Prepared p(ramp(4, 4));
    p.at(0.5f, 0.5f);
    const std::size_t bytes = p.store.bytes();
    p.store.prepare(p.scene);
    EXPECT_EQ(p.store.bytes(), bytes);
    EXPECT_GT(bytes, 0u);
    Scene other;
    p.store.prepare(other);
    EXPECT_EQ(p.store.bytes(), 0u) << "and forgets what the scene no longer has";
    EXPECT_EQ(p.at(0.5f, 0.5f), Vec4f(1));
}

// Each image is within its limits, and so is each file; 65 of them hold more than 4 billion texels in 5 MB.
TEST(TextureStore, RefusesSmallFilesThatHoldBillionsOfTexels)
{
    constexpr int kSide = 8192;
    const test::TempFolder folder;
    const std::string path = (folder.path() / "flat.png").string();
    {
        const OIIO::ImageSpec spec(kSide, kSide, 1, OIIO::TypeDesc::UINT8);
        const std::vector<unsigned char> row(kSide, 77);
        const auto writer = OIIO::ImageOutput::create(path);
        ASSERT_TRUE(writer && writer->open(path, spec));
        for (int y = 0; y < kSide; ++y) ASSERT_TRUE(writer->write_scanline(y, 0, OIIO::TypeDesc::UINT8, row.data()));
    }
    for (const int images : {3, 65}) {
        Scene scene;
        for (int i = 0; i < images; ++i) {
            Texture texture;
            texture.path = path;
            scene.add(texture);
        }
        TextureStore store(std::size_t(1) << 30);
        if (images == 3) EXPECT_NO_THROW(store.prepare(scene));
        else EXPECT_THROW(store.prepare(scene), Error);
    }
}

}  // namespace
}  // namespace occam
