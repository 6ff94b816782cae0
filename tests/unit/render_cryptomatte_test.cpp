// Tests of Cryptomatte: ids by the specification's own examples, coverages in a whole picture, and what files keep.
#include "render/cryptomatte.h"

#include <gtest/gtest.h>
#include <occam/occam.h>

#include <bit>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/shape_builders.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

// The values are those in the unit tests of Psyop's own implementation (Cryptomatte 1.2.0).
TEST(Cryptomatte, IdsAreThoseOfTheSpecification)
{
    EXPECT_EQ(render::murmur3("hello"), 0x248bfa47u);
    EXPECT_FLOAT_EQ(render::matte_id("hello"), 6.0705627102400005616e-17f);
    EXPECT_FLOAT_EQ(render::matte_id("cube"), -4.08461912519e+15f);
    EXPECT_FLOAT_EQ(render::matte_id("sphere"), 2.79018604383e+15f);
    EXPECT_FLOAT_EQ(render::matte_id("plane"), 3.66557617593e-11f);
    EXPECT_EQ(render::murmur3(""), 0u);
    EXPECT_TRUE(std::isnormal(render::matte_id(""))) << "an exponent of zeros is mended";
}

TEST(Cryptomatte, RanksGoByCoverage)
{
    render::MatteSums sums;
    sums.add(3.0f, 0.5);
    sums.add(2.0f, 1);
    sums.add(5.0f, 0.5);
    sums.add(2.0f, 1);
    for (int i = 0; i < 6; ++i) sums.add(10.0f + float(i), 0.05 * (i + 1));
    float ranks[2 * render::kMatteRanks];
    sums.rank(4, ranks);
    EXPECT_EQ(ranks[0], 2.0f);
    EXPECT_EQ(ranks[1], 0.5f);
    for (int i = 1; i < render::kMatteRanks; ++i) EXPECT_GE(ranks[2 * i - 1], ranks[2 * i + 1]);
    EXPECT_EQ(ranks[2], 3.0f) << "equals go by their bits";
    EXPECT_EQ(ranks[4], 5.0f);
    EXPECT_EQ(ranks[6], 15.0f);
}

TEST(Cryptomatte, OfVeryManyIdsKeepsTheLargestAndLittleMemory)
{
    render::MatteSums sums;
    for (int i = 0; i < 5000; ++i) sums.add(1.0f + float(i), 1e-6 * (i % 97));
    for (int i = 0; i < 6; ++i) sums.add(0.1f * float(i + 1), i + 1);  // they come last
    EXPECT_LE(sums.shares().size(), render::MatteSums::kMostIds);
    float ranks[2 * render::kMatteRanks];
    sums.rank(21, ranks);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(ranks[2 * i], 0.1f * float(6 - i)) << i;
}

// A name that only the second half of the samples show, each after 64 others, is found, whatever the filter's signs: what is
// missing of it is less than a 64th.
TEST(Cryptomatte, ALateNameIsKeptByWhatItCovers)
{
    for (const bool has_signs : {false, true}) {
        render::MatteSums sums;
        double weight = 0;
        for (int sample = 0; sample < 64; ++sample) {
            const double sign = has_signs && sample % 4 == 3 ? -1 : 1;
            for (int i = 0; i < 64; ++i) sums.add(10.0f + float(i), sign * 0.0145);
            sums.add(1.0f, sign * 0.0002);
            if (sample >= 32) sums.add(5.0f, sign * 2 * 0.0718);
            weight += sign;
        }
        EXPECT_EQ(sums.shares().size(), render::MatteSums::kMostIds);
        float ranks[2 * render::kMatteRanks];
        sums.rank(weight, ranks);
        EXPECT_EQ(ranks[0], 5.0f);
        EXPECT_LE(ranks[1], 0.0718f + 1e-6f);
        EXPECT_GT(ranks[1], 0.0718f - 1 / 64.0f);
    }
}

// Holds a floor that fills the picture, and in front of its left half a pane with an opacity of a quarter.
struct Panes {
    Scene scene;
    Camera camera = Camera::look_at({0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 0.5f);

    Panes()
    {
        add("floor", "stone", 1, 3, 0);
        add("a \"pane\"", "glass", 0.25f, 3, -3);
    }
    void add(const std::string& node, const std::string& material, float alpha, float half, float x)
    {
        Material m;
        m.name = material;
        m.base_color.w = alpha;
        m.alpha_mode = alpha < 1 ? AlphaMode::Blend : AlphaMode::Opaque;
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
        cage.face_vertices = {0, 2, 1, 0, 3, 2};
        cage.materials = {scene.add(m)};
        NodeDesc desc;
        desc.name = node;
        desc.place.translation = {x, x < 0 ? 1.0 : 0.0, 0};
        desc.cages = {scene.add(std::move(cage))};
        scene.add_node(scene.root(), desc);
    }
    Image render(const Resources& resources)
    {
        Settings settings{.width = 33, .height = 8, .spp = 16, .filter = FilterKind::Gaussian};
        settings.aovs = Aov::CryptomatteObject | Aov::CryptomatteMaterial;
        return Renderer(resources).render(scene, camera, settings);
    }
};

std::map<std::uint32_t, float> coverages(const Image& image, const std::string& layer, std::size_t pixel)
{
    std::map<std::uint32_t, float> found;
    for (const char* number : {"00", "01", "02"}) {
        const Layer* l = image.find(layer + number);
        EXPECT_TRUE(l && l->full_float && l->channel_count() == 4);
        for (int rank : {0, 2})
            if (const float* p = &l->pixels[pixel * 4 + std::size_t(rank)]; p[1] > 0)
                found[std::bit_cast<std::uint32_t>(p[0])] += p[1];
    }
    return found;
}

std::string text_of(const Image& image, std::string_view end)
{
    for (const render::Attribute& a : image.attributes)
        if (a.name.starts_with("cryptomatte/") && a.name.ends_with(end)) return std::get<std::string>(a.value);
    return "";
}

TEST(Cryptomatte, PixelsSayHowMuchOfEachNameTheyShow)
{
    Panes panes;
    const TempFolder folder;
    const Image made = panes.render({.threads = 1});
    made.write(folder.path() / "mattes.exr");
    const Image image = Image::read(folder.path() / "mattes.exr");
    const nlohmann::json objects = nlohmann::json::parse(text_of(made, "/manifest"));
    EXPECT_EQ(objects.size(), 2u);
    EXPECT_EQ(text_of(made, "/name"), "CryptoObject");
    EXPECT_EQ(text_of(made, "/conversion"), "uint32_to_float32");
    const auto id = [&](const char* name) {
        return std::uint32_t(std::stoul(objects.at(name).get<std::string>(), nullptr, 16));
    };
    const std::size_t row = 4 * 33;
    for (const std::size_t x : {7u, 10u}) {
        auto shown = coverages(image, "CryptoObject", row + x);
        EXPECT_NEAR(shown[id("a \"pane\"")], 0.25f, 1e-6f);
        EXPECT_NEAR(shown[id("floor")], 0.75f, 1e-6f);
        shown = coverages(image, "CryptoMaterial", row + x);
        EXPECT_NEAR(shown[std::bit_cast<std::uint32_t>(render::matte_id("glass"))], 0.25f, 1e-6f);
        EXPECT_NEAR(shown[std::bit_cast<std::uint32_t>(render::matte_id("stone"))], 0.75f, 1e-6f);
    }
    auto right = coverages(image, "CryptoObject", row + 26);
    EXPECT_EQ(right.size(), 1u);
    EXPECT_NEAR(right[id("floor")], 1, 1e-6f);
    auto edge = coverages(image, "CryptoObject", row + 16);
    EXPECT_GT(edge[id("a \"pane\"")], 0.02f) << "the pane's edge runs through the pixel";
    EXPECT_LT(edge[id("a \"pane\"")], 0.23f);
}

// Files of old programs have names in Latin-1. Their ids are those of the bytes in the file.
TEST(Cryptomatte, ManifestsTellNamesApartThatAreNoUtf8)
{
    Panes panes;
    const std::string with_u = "M\xfcll", with_o = "M\xf6ll", utf8 = "M\xc3\xa4ll";
    for (const std::string& name : {with_u, with_o, utf8}) panes.add(name, "plain", 0.1f, 1, 1);
    const nlohmann::json objects = nlohmann::json::parse(text_of(panes.render({.threads = 1}), "/manifest"));
    EXPECT_EQ(objects.size(), 5u);
    const auto expect_id = [&](const char* in_manifest, const std::string& name) {
        char id[9];
        std::snprintf(id, sizeof id, "%08x", std::bit_cast<std::uint32_t>(render::matte_id(name)));
        EXPECT_EQ(objects.value(in_manifest, ""), id) << in_manifest;
    };
    expect_id("M\xc3\xbcll", with_u);
    expect_id("M\xc3\xb6ll", with_o);
    expect_id("M\xc3\xa4ll", utf8);
}

// Behind 64 veils with names of their own and many that repeat a name lies a wall that covers more than any of them. The
// surfaces of a sample are shaded one after the other, those of many samples at once.
TEST(Cryptomatte, IsTheSameForAnyBatchesWhereAPixelShowsVeryManyNames)
{
    constexpr int kVeils = 64;
    constexpr float kEach = 0.0145f;
    Scene scene;
    const auto add = [&](const std::string& name, float opacity, double z) {
        Material m;
        m.name = name;
        m.base_color.w = opacity;
        m.alpha_mode = opacity < 1 ? AlphaMode::Blend : AlphaMode::Opaque;
        Cage cage = unit_square();
        cage.materials = {scene.add(m)};
        NodeDesc desc;
        desc.name = name;
        desc.place.translation = {-4, -4, z};
        desc.place.scale = Vec3d(8);
        desc.cages = {scene.add(std::move(cage))};
        scene.add_node(scene.root(), desc);
    };
    for (int i = 0; i < kVeils; ++i) add("veil " + std::to_string(i), kEach / (1 - kEach * float(i)), -0.01 * i);
    for (int i = 0; i < 40; ++i) add("veil 0", 0.0002f, -0.01 * (kVeils + i));
    add("wall", 1, -2);
    const Camera camera = Camera::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.5f);
    Settings settings{.width = 8, .height = 8, .spp = 16, .integrator = IntegratorKind::Direct, .bounces = 0};
    settings.aovs = Aov::CryptomatteObject | Aov::CryptomatteMaterial;
    const Image first = Renderer({.threads = 1}).render(scene, camera, settings);
    const auto wall = std::bit_cast<std::uint32_t>(render::matte_id("wall"));
    for (const std::size_t pixel : {0u, 27u, 63u}) {
        const float covers = coverages(first, "CryptoObject", pixel)[wall];
        EXPECT_LE(covers, 1 - kVeils * kEach);
        EXPECT_GT(covers, 1 - kVeils * kEach - 1 / 64.0f);
    }
    const auto expect_same = [&](const Image& image, const char* what) {
        for (const Layer& layer : first.layers()) EXPECT_TRUE(layer.pixels == image.find(layer.name)->pixels) << what;
    };
    const std::size_t least = Renderer({.threads = 1}).memory_floor(scene) + (1 << 20);
    expect_same(Renderer({.threads = 1, .memory_bytes = least}).render(scene, camera, settings), "least memory");
    settings.progressive = true;
    expect_same(Renderer({.threads = 1}).render(scene, camera, settings), "rounds");
    std::string checkpoint;
    Image stopped;
    for (double seconds = 0.05;; seconds *= 1.5) {
        settings.deadline_s = seconds;
        Renderer renderer({.threads = 1});
        Job job = renderer.start(scene, camera, settings, std::move(checkpoint));
        job.wait();
        checkpoint = job.checkpoint();
        if (!checkpoint.empty()) continue;
        stopped = job.image();
        break;
    }
    expect_same(stopped, "stopped and resumed");
}

TEST(Cryptomatte, IsTheSameForAnyNumberOfThreads)
{
    Panes panes;
    const Image one = panes.render({.threads = 1});
    const Image two = panes.render({.threads = 2, .memory_bytes = Renderer({.threads = 2}).memory_floor(panes.scene)});
    ASSERT_EQ(one.layers().size(), 7u);
    for (const Layer& layer : one.layers()) EXPECT_EQ(layer.pixels, two.find(layer.name)->pixels) << layer.name;
}

}  // namespace
}  // namespace occam::test
