#include "render/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "render/display.h"

namespace occam::render {
namespace {

namespace fs = std::filesystem;

class ImageFile : public testing::Test {
protected:
    void SetUp() override
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder = fs::temp_directory_path() / ("occam_image_" + std::to_string(getpid()) + "_" + test->name());
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }

    std::size_t files() const
    {
        return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }

    fs::path folder;
};

Image gradient(int width, int height)
{
    Image image(width, height);
    image.add_layer("beauty", {"R", "G", "B", "A"});
    image.add_layer("depth", {"Z"}, true);
    image.add_layer("normal", {"X", "Y", "Z"});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = std::size_t(y * width + x);
            const float v[4] = {float(x) / 8, float(y) / 8, 0.25f, 1};
            std::copy_n(v, 4, &image.layer(0).pixels[4 * i]);
            image.layer(1).pixels[i] = x == 0 ? INFINITY : 1.0f + 1e-6f * float(x);
            image.layer(2).pixels[3 * i + 2] = -1;
        }
    return image;
}

// Computes the checksum independently, byte by byte from its definition.
std::uint64_t fnv_of_rgb(const Layer& beauty)
{
    std::uint64_t h = 14695981039346656037ull;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t bits;
            std::memcpy(&bits, &beauty.pixels[i + c], 4);
            for (int byte = 0; byte < 4; ++byte) h = (h ^ ((bits >> (8 * byte)) & 255)) * 1099511628211ull;
        }
    return h;
}

TEST(Image, ChecksumIsFnv1aOfTheColours)
{
    Image image = gradient(5, 3);
    EXPECT_EQ(image.checksum(), fnv_of_rgb(image.layers()[0]));
    const std::uint64_t before = image.checksum();
    image.layer(0).pixels[3] = 0.5f;  // alpha is not part of the checksum
    EXPECT_EQ(image.checksum(), before);
    image.layer(0).pixels[4] += 1e-7f;
    EXPECT_NE(image.checksum(), before);
}

TEST_F(ImageFile, ExrKeepsLayersInfinityAndFullFloats)
{
    const Image image = gradient(6, 4);
    image.write(folder / "a.exr");
    const Image back = Image::read(folder / "a.exr");
    ASSERT_EQ(back.layers().size(), 3u);
    EXPECT_EQ(back.find("beauty")->channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    EXPECT_EQ(back.find("beauty")->pixels, image.find("beauty")->pixels) << "eighths are exact in half";
    EXPECT_EQ(back.find("depth")->pixels, image.find("depth")->pixels) << "depth is float whatever the colours are";
    EXPECT_EQ(back.find("normal")->pixels, image.find("normal")->pixels);
}

TEST_F(ImageFile, HalfColoursAreClampedAndFloatColoursAreExact)
{
    Image image = gradient(2, 1);
    image.layer(0).pixels[0] = 1e6f;
    image.layer(0).pixels[1] = 0.1f;
    image.write(folder / "half.exr");
    image.write(folder / "float.exr", {.half = false});
    const Image half = Image::read(folder / "half.exr"), full = Image::read(folder / "float.exr");
    EXPECT_EQ(half.find("beauty")->pixels[0], 65504.0f);
    EXPECT_NEAR(half.find("beauty")->pixels[1], 0.1f, 0.1f / 2048);
    EXPECT_EQ(full.find("beauty")->pixels, image.find("beauty")->pixels);
}

TEST_F(ImageFile, ACropKnowsItsPlaceInTheFrame)
{
    Image image = gradient(4, 2);
    image.x0 = 10;
    image.y0 = 20;
    image.full_width = 100;
    image.full_height = 50;
    image.write(folder / "crop.exr");
    const Image back = Image::read(folder / "crop.exr");
    EXPECT_EQ(back.x0, 10);
    EXPECT_EQ(back.y0, 20);
    EXPECT_EQ(back.full_width, 100);
    EXPECT_EQ(back.full_height, 50);
}

TEST_F(ImageFile, AllFormatsAreWrittenUnderTheirFinalNameAlone)
{
    const Image image = gradient(16, 16);
    for (const char* name : {"a.exr", "a.png", "a.jpg", "a.tif", "a.hdr"}) {
        image.write(folder / name);
        EXPECT_TRUE(fs::file_size(folder / name) > 0) << name;
    }
    EXPECT_EQ(files(), 5u) << "nothing temporary is left";
}

// The head of a Radiance file says in which order its pixels are.
TEST_F(ImageFile, TheRowsOfRadianceFilesBeginWhereTheirHeadSays)
{
    // Three columns and two rows of red texels: 1, 2, 3 above 4, 5, 6, in units of a 128th.
    const auto read = [&](const char* sizes, std::initializer_list<int> reds) {
        std::ofstream file(folder / "a.hdr", std::ios::binary);
        file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" << sizes << '\n';
        for (const int red : reds) file << char(red) << '\0' << '\0' << char(129);
        file.close();
        std::vector<int> found;
        const Image image = Image::read(folder / "a.hdr");
        const std::size_t channels = image.find("beauty")->channel_count();
        for (std::size_t i = 0; i < 6; ++i)
            found.push_back(int(std::lround(image.find("beauty")->pixels[i * channels] * 128)));
        return found;
    };
    const std::vector<int> expected{1, 2, 3, 4, 5, 6};
    EXPECT_EQ(read("-Y 2 +X 3", {1, 2, 3, 4, 5, 6}), expected);
    EXPECT_EQ(read("+Y 2 +X 3", {4, 5, 6, 1, 2, 3}), expected);
    EXPECT_EQ(read("-Y 2 -X 3", {3, 2, 1, 6, 5, 4}), expected);
    EXPECT_EQ(read("+Y 2 -X 3", {6, 5, 4, 3, 2, 1}), expected);
    EXPECT_THROW(read("+X 3 -Y 2", {1, 2, 3, 4, 5, 6}), Error);
}

// The exponent of a large value did not fit into its byte, so that the brightest pixels were black.
TEST_F(ImageFile, WhatIsTooBrightForRadianceIsItsLargestValue)
{
    constexpr float kLargest = 0x1.fep126f;
    const float values[] = {INFINITY, std::numeric_limits<float>::max(), 0x1p127f, kLargest, 0x1p126f, 1, -INFINITY, NAN};
    const float expected[] = {kLargest, kLargest, kLargest, kLargest, 0x1p126f, 1, 0, 0};
    Image image(8, 1);
    Layer& beauty = image.add_layer("beauty", {"R", "G", "B"});
    for (std::size_t i = 0; i < 8; ++i) std::fill_n(&beauty.pixels[3 * i], 3, values[i]);
    image.write(folder / "bright.hdr");
    const Image read = Image::read(folder / "bright.hdr");
    for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(read.layers()[0].pixels[3 * i + c], expected[i]) << i;
}

TEST_F(ImageFile, LayersThatAFileCannotKeepApartAreRefusedByName)
{
    const auto error_of = [&](const std::vector<std::pair<std::string, std::vector<std::string>>>& layers) {
        Image image(2, 2);
        image.add_layer("beauty", {"R", "G", "B"});
        for (const auto& [name, channels] : layers) image.add_layer(name, channels);
        try {
            image.write(folder / "layers.exr");
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), Error::Kind::Output);
            return std::string(error.what());
        }
        return std::string();
    };
    const std::string longest(253, 'n'), too_long = longest + 'n';
    const auto names = [&](const std::string& error, const std::string& name) {
        return error.find("cannot be written: layer '" + name + "' ") != std::string::npos;
    };
    EXPECT_TRUE(names(error_of({{"", {"Z"}}}), ""));
    EXPECT_TRUE(names(error_of({{too_long, {"Z"}}}), too_long));
    EXPECT_TRUE(names(error_of({{"twice", {"X"}}, {"twice", {"X"}}}), "twice"));
    EXPECT_TRUE(names(error_of({{"twice", {"X", "X"}}}), "twice"));
    EXPECT_TRUE(names(error_of({{"beauty", {"R"}}}), "beauty"));
    EXPECT_TRUE(names(error_of({{"dotted", {"a.X"}}}), "dotted"));
    EXPECT_TRUE(names(error_of({{"nameless", {""}}}), "nameless"));
    EXPECT_TRUE(names(error_of({{std::string("zero\0", 5), {"X"}}}), "zero\\x00"));
    EXPECT_EQ(files(), 0u) << "nothing is left";
    EXPECT_EQ(error_of({{longest, {"Z"}}, {"a.b", {"X"}}, {"a", {"X"}}}), "");
    EXPECT_TRUE(Image::read(folder / "layers.exr").find(longest));
}

TEST_F(ImageFile, AnExposureThatIsNoNumberIsAnError)
{
    for (const float exposure : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        for (const char* name : {"a.png", "a.exr"})
            EXPECT_THROW(gradient(8, 8).write(folder / name, {.exposure_ev = exposure}), Error) << name;
    EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(ImageFile, PngCarriesTheSrgbCurve)
{
    const Image image = gradient(8, 8);
    image.write(folder / "a.png", {.exposure_ev = 0, .tonemap = Tonemap::Srgb});
    const Image back = Image::read(folder / "a.png");
    const Layer& was = *image.find("beauty");
    const Layer& is = *back.find("beauty");
    for (std::size_t i = 0; i < 64; ++i)
        for (std::size_t c = 0; c < 3; ++c)  // half a step of 1 / 255 in the encoded value
            EXPECT_NEAR(srgb_from_linear(is.pixels[is.channel_count() * i + c]), srgb_from_linear(was.pixels[4 * i + c]),
                        0.501f / 255);
}

TEST_F(ImageFile, TransparentPixelsAndLinearOnesAreReadAsTheyWere)
{
    Image image = gradient(2, 1);
    const float half_covered[4] = {0.25f, 0.125f, 0.5f, 0.5f};  // multiplied by coverage
    std::copy_n(half_covered, 4, image.layer(0).pixels.begin());
    const auto read_back = [&](const char* name, Tonemap curve) {
        image.write(folder / name, {.exposure_ev = 0, .tonemap = curve});
        const Layer beauty = *Image::read(folder / name).find("beauty");
        ASSERT_EQ(beauty.channel_count(), 4u);
        for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(beauty.pixels[c], half_covered[c], 0.01f) << name << ' ' << c;
    };
    read_back("a.png", Tonemap::Srgb);
    read_back("a.tif", Tonemap::Srgb);
    read_back("linear.png", Tonemap::None);
}

// The head of a PNG may name the power of its encoding.
TEST_F(ImageFile, PngFilesAreReadByThePowerThatTheyName)
{
    Image image(1, 1);
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(3, 0.5f);
    image.write(folder / "a.png", {.exposure_ev = 0, .tonemap = Tonemap::None});
    std::ifstream stream(folder / "a.png", std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t at = bytes.find("gAMA") + 4;
    const auto read_with = [&](int hundred_thousandths) {
        for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = char(hundred_thousandths >> (24 - 8 * i));
        // The checksum is not that of the chunk, which no more than a warning is about.
        std::ofstream(folder / "b.png", std::ios::binary) << bytes;
        return Image::read(folder / "b.png").find("beauty")->pixels[0];
    };
    const float stored = 128 / 255.0f;
    EXPECT_NEAR(read_with(100000), stored, 1e-5f);
    EXPECT_NEAR(read_with(50000), stored * stored, 1e-5f);
    EXPECT_NEAR(read_with(45455), linear_from_srgb(stored), 1e-5f) << "this stands for sRGB";
    EXPECT_NEAR(read_with(0), linear_from_srgb(stored), 1e-5f) << "this is nothing";
}

TEST_F(ImageFile, AnExistingFileIsReplaced)
{
    std::ofstream(folder / "a.png") << "old";
    gradient(3, 3).write(folder / "a.png");
    EXPECT_EQ(Image::read(folder / "a.png").width, 3);
    EXPECT_EQ(files(), 1u);
}

Error::Kind kind_of_failure(const Image& image, const fs::path& file)
{
    try {
        image.write(file);
    } catch (const Error& error) {
        EXPECT_EQ(error.file(), file.string());
        return error.kind();
    }
    ADD_FAILURE() << "was written: " << file;
    return Error::Kind::BadInput;
}

TEST_F(ImageFile, WhatCannotBeWrittenIsAnOutputError)
{
    const Image image = gradient(3, 3);
    EXPECT_EQ(kind_of_failure(image, folder / "missing" / "a.png"), Error::Kind::Output);
    EXPECT_EQ(kind_of_failure(image, folder / "a.bmpx"), Error::Kind::BadInput);
    fs::create_directory(folder / "folder.png");
    EXPECT_EQ(kind_of_failure(image, folder / "folder.png"), Error::Kind::Output);
    if (geteuid() != 0) {
        fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
        EXPECT_EQ(kind_of_failure(image, folder / "a.png"), Error::Kind::Output);
        fs::permissions(folder, fs::perms::owner_all);
    }
    EXPECT_EQ(files(), 1u);
}

// An application may have taken or changed the layers.
TEST_F(ImageFile, PicturesWithoutTheirPixelsAreRefusedInEveryFormat)
{
    Image fewer(4, 3), more(4, 3);
    fewer.add_layer("beauty", {"R", "G", "B", "A"}).pixels.resize(4);
    more.add_layer("beauty", {"R", "G", "B", "A"}).pixels.resize(400);
    for (const char* name : {"a.exr", "a.png", "a.jpg", "a.hdr", "a.tif"})
        for (const Image* image : {&fewer, &more}) EXPECT_THROW(image->write(folder / name), Error) << name;
    for (const char* name : {"a.exr", "a.png", "a.jpg", "a.hdr", "a.tif"})
        EXPECT_THROW(Image(4, 3).write(folder / name), Error) << name;
    EXPECT_EQ(files(), 0u);
}

TEST_F(ImageFile, WhatIsNoPictureIsRefused)
{
    std::ofstream(folder / "a.exr") << "not an image";
    EXPECT_THROW(Image::read(folder / "a.exr"), Error);
    EXPECT_THROW(Image::read(folder / "none.exr"), Error);
    EXPECT_THROW(Image::read(folder), Error);
}

TEST(Display, ExposureAndCurvesDoWhatTheyPromise)
{
    Image image(1, 1);
    image.add_layer("beauty", {"R", "G", "B"}).pixels = {0.25f, 0.5f, 4.0f};
    const auto one_stop = display_image(image, {.exposure_ev = 1, .tonemap = Tonemap::None});
    EXPECT_EQ(one_stop.pixels, (std::vector<float>{0.5f, 1.0f, 1.0f}));
    for (float x : {0.0f, 0.002f, 0.2f, 0.9f, 1.0f}) EXPECT_NEAR(linear_from_srgb(srgb_from_linear(x)), x, 1e-6f);
    EXPECT_NEAR(srgb_from_linear(0.2140411f), 0.5f, 1e-5f);
    for (const Tonemap curve : {Tonemap::Aces, Tonemap::Filmic}) {
        const auto filmic = display_image(image, {.exposure_ev = 0, .tonemap = curve});
        EXPECT_TRUE(filmic.pixels[0] < filmic.pixels[1] && filmic.pixels[1] < filmic.pixels[2] && filmic.pixels[2] < 1);
    }
}

// The test checks black, grey and white of the filmic curve, and that it rises without a jump.
TEST(Display, TheFilmicCurveRisesFromBlackToWhite)
{
    float last = 0;
    for (int i = 0; i <= 1000; ++i) {
        Image image(1, 1);
        image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(3, 0.01f * float(i));
        const float shown = display_image(image, {.exposure_ev = 0}).pixels[1];
        EXPECT_GE(shown, last) << i;  // the first value is 0
        EXPECT_LT(shown - last, 0.12f) << i;
        last = shown;
    }
    const auto at = [](float x) {
        Image image(1, 1);
        image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(3, x);
        return display_image(image, {.exposure_ev = 0}).pixels[1];
    };
    EXPECT_EQ(at(0), 0);
    EXPECT_NEAR(at(0.3f), srgb_from_linear(0.3f), 1e-5f);
    for (const float white : {8.0f, 9.0f, 1e9f}) EXPECT_NEAR(at(white), 1, 1e-6f) << white;
}

Image grey(std::size_t pixels, float value)
{
    Image image(int(pixels), 1);
    image.add_layer("beauty", {"R", "G", "B", "A"}).pixels.assign(4 * pixels, value);
    for (std::size_t i = 0; i < pixels; ++i) image.layer(0).pixels[4 * i + 3] = 1;
    return image;
}

TEST(Display, AutomaticExposureLeavesWhatIsLitAsUsual)
{
    for (const float usual : {0.13f, 0.25f, 0.49f}) EXPECT_EQ(automatic_exposure(grey(100, usual)), 0) << usual;
    EXPECT_NEAR(automatic_exposure(grey(100, 2)), -2, 1e-5f);         // darkens it to 0.5
    EXPECT_NEAR(automatic_exposure(grey(100, 1.0f / 64)), 3, 1e-5f);  // brightens it to 0.125
    EXPECT_NEAR(automatic_exposure(grey(100, 1e30f)), -kMostStops, 1e-5f);
    EXPECT_NEAR(automatic_exposure(grey(100, 1e-30f)), kMostStops, 1e-5f);
    EXPECT_EQ(automatic_exposure(grey(100, 0)), 0);
    EXPECT_EQ(automatic_exposure(grey(100, std::numeric_limits<float>::infinity())), 0);
    EXPECT_EQ(automatic_exposure(grey(100, std::nanf(""))), 0);
    EXPECT_EQ(automatic_exposure(Image(3, 3)), 0);
}

TEST(Display, AutomaticExposureAsksOnlyWhatIsSeenAndLit)
{
    Image spot = grey(1000, 1e-6f);  // a stage in the dark
    for (std::size_t i = 0; i < 4 * 50; ++i) spot.layer(0).pixels[i] = i % 4 == 3 ? 1.0f : 0.3f;
    EXPECT_EQ(automatic_exposure(spot), 0);
    Image cut_out = grey(1000, 8);  // nothing covers the bright part
    for (std::size_t i = 0; i < 1000; ++i) {
        float* pixel = &cut_out.layer(0).pixels[4 * i];
        if (i < 900) pixel[3] = 0;
        else pixel[0] = pixel[1] = pixel[2] = 0.25f;
    }
    EXPECT_EQ(automatic_exposure(cut_out), 0);
    Image lamp = grey(1000, 1.0f / 64);  // a dark room with a visible lamp, which must not be overexposed
    for (std::size_t i = 0; i < 4 * 50; ++i) lamp.layer(0).pixels[i] = 1;
    EXPECT_NEAR(automatic_exposure(lamp), 1, 1e-4f);
    Image view = grey(100, 16);
    view.is_light = false;
    EXPECT_EQ(automatic_exposure(view), 0);
    EXPECT_NEAR(display_image(view, {}).pixels[0], 1, 1e-6f);
}

}  // namespace
}  // namespace occam::render
