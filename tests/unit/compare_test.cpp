#include "render/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/vec.h"

namespace occam::render {
namespace {

Image flat(int width, int height, float value)
{
    Image image(width, height);
    Layer& beauty = image.add_layer("beauty", {"R", "G", "B"});
    std::fill(beauty.pixels.begin(), beauty.pixels.end(), value);
    return image;
}

TEST(Compare, EqualPicturesAreZeroApart)
{
    const auto d = compare(flat(4, 4, 0.5f), flat(4, 4, 0.5f), "beauty");
    EXPECT_EQ(d.mse, 0);
    EXPECT_EQ(d.max, 0);
    EXPECT_TRUE(std::isinf(d.psnr));
    EXPECT_EQ(d.pixels, 16u);
}

// One of 1000 pixels differs by 0.5 in one channel from a reference of 0.5.
TEST(Compare, FiguresFollowTheirDefinitions)
{
    const Image b = flat(100, 10, 0.5f);
    Image a = b;
    a.layer(0).pixels[3 * 77 + 1] = 1.0f;
    const auto d = compare(a, b, "beauty");
    EXPECT_NEAR(d.mse, 0.25 / 3000, 1e-12);
    EXPECT_NEAR(d.rmse, std::sqrt(0.25 / 3000), 1e-12);
    EXPECT_NEAR(d.rel_mse, 0.25 / 0.26 / 3000, 1e-12);
    EXPECT_NEAR(d.psnr, 10 * std::log10(3000 / 0.25), 1e-9);
    EXPECT_EQ(d.max, 0.5);
    EXPECT_EQ(d.p999, 0) << "the 999th of 1000";
    a.layer(0).pixels[0] = 0.75f;
    EXPECT_EQ(compare(a, b, "beauty").p999, 0.25) << "the 999th of 1000";
}

// Differences of all sizes, of which many are equal.
TEST(Compare, ThePercentileIsThatOfASortedList)
{
    const Image b = flat(100, 50, 0.0f);
    for (const int kinds : {3, 40, 100'000}) {
        Image a = b;
        std::vector<double> sorted;
        std::uint32_t random = 7;
        for (std::size_t i = 0; i < 5000; ++i) {
            random = random * 1664525 + 1013904223;
            const int kind = static_cast<int>((random >> 8) % static_cast<std::uint32_t>(kinds));
            const float value = std::ldexp(1.0f + static_cast<float>(kind) / 1000.0f, kind % 60 - 30);
            a.layer(0).pixels[3 * i + i % 3] = i % 2 ? value : -value;
            sorted.push_back(double(value));
        }
        std::sort(sorted.begin(), sorted.end());
        const auto d = compare(a, b, "beauty");
        EXPECT_EQ(d.p999, sorted[4994]) << kinds;
        EXPECT_EQ(d.max, sorted[4999]) << kinds;
    }
}

TEST(Compare, WhatIsNotANumberIsCountedAndLeftOut)
{
    const Image b = flat(2, 2, 0.5f);
    Image a = b;
    a.layer(0).pixels[0] = NAN;
    a.layer(0).pixels[3] = INFINITY;
    const auto d = compare(a, b, "beauty");
    EXPECT_EQ(d.incomparable, 2u);
    EXPECT_EQ(d.mse, 0);
}

TEST(Compare, InfinityOnBothSidesIsEqual)
{
    const auto d = compare(flat(2, 2, INFINITY), flat(2, 2, INFINITY), "beauty");
    EXPECT_EQ(d.incomparable, 0u);
    EXPECT_EQ(d.mse, 0);
    EXPECT_EQ(d.rel_mse, 0);
}

TEST(Compare, AlphaOfBeautyDoesNotCount)
{
    Image a(1, 1), b(1, 1);
    a.add_layer("beauty", {"R", "G", "B", "A"}).pixels = {1, 1, 1, 0};
    b.add_layer("beauty", {"R", "G", "B"}).pixels = {1, 1, 1};
    EXPECT_EQ(compare(a, b, "beauty").max, 0);
}

// A black picture that covers everything is another one than a clear one.
TEST(Compare, AlphaOfBeautyIsMeasuredByItself)
{
    Image a(2, 1), b(2, 1);
    a.add_layer("beauty", {"R", "G", "B", "A"}).pixels = {0, 0, 0, 1, 0, 0, 0, 1};
    b.add_layer("beauty", {"R", "G", "B", "A"}).pixels = {0, 0, 0, 1, 0, 0, 0, 0.5f};
    a.add_layer("depth", {"Z"});
    b.add_layer("depth", {"Z"});
    const auto all = compare(a, b);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].layer, "beauty");
    EXPECT_EQ(all[0].max, 0);
    EXPECT_EQ(all[1].layer, kAlphaOfBeauty);
    EXPECT_EQ(all[1].max, 0.5);
    EXPECT_EQ(all[1].mse, 0.125);
    const Image heat = heat_map(a, b, std::string(kAlphaOfBeauty), 0.5);
    EXPECT_EQ(heat.layers()[0].pixels, (std::vector<float>{0, 0, 0, 1, 1, 1}));
}

TEST(Compare, ALayerOfOtherChannelsHasNoFigures)
{
    Image a = flat(2, 2, 0.5f), b = a;
    a.add_layer("foo", {"R", "G"});
    b.add_layer("foo", {"R"});
    const auto all = compare(a, b);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].mse, 0);
    EXPECT_TRUE(all[1].has_other_channels);
    EXPECT_EQ(all[1].incomparable, 4u);
    EXPECT_TRUE(std::isnan(all[1].mse));
    EXPECT_THROW(compare(a, b, "foo"), Error);
    EXPECT_THROW(heat_map(a, b, "foo", 1), Error);
}

TEST(Compare, WhereNothingCanBeComparedThereIsNoFigure)
{
    const auto d = compare(flat(2, 2, NAN), flat(2, 2, 0.5f), "beauty");
    EXPECT_EQ(d.incomparable, 4u);
    for (const double figure : {d.mse, d.rmse, d.rel_mse, d.psnr, d.max, d.p999}) EXPECT_TRUE(std::isnan(figure));
    EXPECT_NE(to_json({d}).find("\"mse\": null"), std::string::npos) << to_json({d});
}

TEST(Compare, CommonLayersAreComparedBeautyFirst)
{
    Image a(1, 1), b(1, 1);
    a.add_layer("depth", {"Z"});
    a.add_layer("beauty", {"R", "G", "B"});
    a.add_layer("uv", {"U", "V"});
    b.add_layer("beauty", {"R", "G", "B"});
    b.add_layer("depth", {"Z"});
    const auto all = compare(a, b);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].layer, "beauty");
    EXPECT_EQ(all[1].layer, "depth");
}

TEST(Compare, DifferentSizesOrChannelsAreRefused)
{
    EXPECT_THROW(compare(flat(2, 2, 0), flat(3, 2, 0), "beauty"), Error);
    EXPECT_THROW(compare(flat(2, 2, 0), flat(2, 2, 0), "depth"), Error);
    Image luminance(2, 2);
    luminance.add_layer("beauty", {"Y"});
    EXPECT_THROW(compare(flat(2, 2, 0), luminance, "beauty"), Error);
    Image other(2, 2);
    other.add_layer("depth", {"Z"});
    EXPECT_THROW(compare(flat(2, 2, 0), other), Error);
}

// Two crops of one size show different things.
// The pixels of a layer are an application's to change, and so are the sides of a picture.
TEST(Compare, LayersWithoutTheirPixelsAreRefused)
{
    const Image whole = flat(512, 512, 0.5f);
    Image cut = whole, grown = whole, ragged = whole, endless = whole;
    cut.layer(0).pixels.resize(3);
    grown.width = 513;
    ragged.layer(0).pixels.pop_back();
    endless.width = endless.height = 1 << 30;  // with 16 channels, 64 bits count these values as none
    endless.layer(0).channels.resize(16);
    endless.layer(0).pixels.clear();
    for (const Image* image : {&cut, &grown, &ragged, &endless}) {
        EXPECT_THROW(compare(*image, *image), Error);
        EXPECT_THROW(compare(*image, *image, "beauty"), Error);
        EXPECT_THROW(heat_map(*image, *image, "beauty", 1), Error);
        EXPECT_THROW((void)image->checksum(), Error);
    }
    EXPECT_THROW(compare(whole, cut), Error);
    EXPECT_THROW(compare(cut, whole), Error);
    try {
        compare(cut, whole);
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("layer beauty does not hold a value of each channel for each pixel"),
                  std::string::npos)
            << error.what();
    }
    Image other = whole;
    other.add_layer("depth", {"Z"}).pixels.clear();
    EXPECT_THROW(compare(other, other, "depth"), Error);
    EXPECT_EQ(other.checksum(), whole.checksum()) << "only beauty counts";
}

// Programs write the channels of a file in any order, and OpenEXR files in that of their names.
TEST(Compare, ColoursAreFoundByTheirNames)
{
    Image a(1, 1), b(1, 1);
    a.add_layer("beauty", {"A", "B", "G", "R"}).pixels = {1, 0.3f, 0.2f, 0.1f};
    b.add_layer("beauty", {"R", "G", "B", "Z"}).pixels = {0.1f, 0.2f, 0.3f, 7};
    EXPECT_EQ(compare(a, b, "beauty").max, 0);
    EXPECT_EQ(a.checksum(), b.checksum());
    Image grey(1, 1), three(1, 1);
    grey.add_layer("beauty", {"Y", "A"}).pixels = {0.25f, 0.5f};
    three.add_layer("beauty", {"R", "G", "B"}).pixels = {0.25f, 0.25f, 0.25f};
    EXPECT_EQ(compare(grey, grey, "beauty").max, 0);
    EXPECT_EQ(grey.checksum(), three.checksum());
    EXPECT_THROW(compare(grey, three, "beauty"), Error) << "their channels differ";
}

TEST(Compare, PartsOfAFrameAreComparedInOnePlaceAlone)
{
    Image left = flat(2, 2, 0), right = left, of_larger = left;
    for (Image* image : {&left, &right}) image->full_width = 4;
    right.x0 = 2;
    of_larger.full_width = 8;
    EXPECT_EQ(compare(left, left, "beauty").max, 0);
    EXPECT_EQ(compare(right, flat(2, 2, 0), "beauty").max, 0) << "a PNG file does not say of what it is a part";
    for (const auto& [a, b] : {std::pair(&left, &right), std::pair(&left, &of_larger)}) {
        EXPECT_THROW(compare(*a, *b), Error);
        EXPECT_THROW(heat_map(*a, *b, "beauty", 1), Error);
    }
    try {
        compare(left, right, "beauty");
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("2x2 pixels from 0,0 of a frame of 4x2, and 2x2 pixels from 2,0 of"),
                  std::string::npos)
            << error.what();
    }
}

TEST(Compare, HeatGoesFromBlackOverRedToWhite)
{
    const Image b = flat(3, 1, 0);
    Image a = b;
    a.layer(0).pixels[3] = 1.0f / 3;
    a.layer(0).pixels[6] = NAN;
    const Image heat = heat_map(a, b, "beauty", 1);
    const auto& p = heat.layers()[0].pixels;
    EXPECT_EQ(Vec3f(p[0], p[1], p[2]), Vec3f(0, 0, 0));
    EXPECT_NEAR(p[3], 1, 1e-6);
    EXPECT_NEAR(p[4], 0, 1e-6);
    EXPECT_EQ(Vec3f(p[6], p[7], p[8]), Vec3f(1, 0, 1));
}

TEST(Compare, JsonHasNoInfinity)
{
    const std::string text = to_json(compare(flat(1, 1, 0), flat(1, 1, 0)));
    EXPECT_NE(text.find("\"psnr\": null"), std::string::npos);
    EXPECT_NE(text.find("\"layer\": \"beauty\""), std::string::npos);
}

}  // namespace
}  // namespace occam::render
