#include "render/film.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "tests/support/statistics.h"

namespace occam::render {
namespace {

SampleResult grey(float value, float depth)
{
    SampleResult s;
    s.radiance = Vec3f(value);
    s.alpha = 1;
    s.albedo = Vec4f(0.5f, 0.25f, 0, 1);
    s.first.depth = depth;
    return s;
}

// Returns the sample moved to `place`, which is measured from the pixel's top left corner.
SampleResult at(SampleResult sample, Vec2f place)
{
    sample.offset = place - Vec2f(0.5f);
    return sample;
}

TEST(Film, APixelIsTheMeanOfItsSamples)
{
    PixelSums sums;
    sums.add(at(grey(1, 4), {0.9f, 0.9f}));
    sums.add(at(grey(2, 5), {0.6f, 0.5f}));
    sums.add(at(SampleResult{}, {0.1f, 0.1f}));
    EXPECT_EQ(sums.beauty(), Vec4f(1, 1, 1, 2.0f / 3));
    EXPECT_EQ(sums.albedo(), Vec4f(1.0f / 3, 0.5f / 3, 0, 2.0f / 3));
}

TEST(Film, DepthIsThatOfTheSampleNearestTheMiddle)
{
    PixelSums sums;
    sums.add(at(grey(1, 4), {0.9f, 0.9f}));
    sums.add(at(grey(2, 5), {0.6f, 0.5f}));
    sums.add(at(SampleResult{}, {0.1f, 0.1f}));
    float depth = 0;
    sums.write(Aov::Depth, &depth);
    EXPECT_EQ(depth, 5);
}

// For the mean of 1, 2, 3 and 6 it is the sum of squared deviations, 14, over n - 1 = 3, over n = 4.
TEST(Film, VarianceIsThatOfTheMean)
{
    PixelSums sums;
    for (float value : {1.0f, 2.0f, 3.0f, 6.0f}) sums.add(at(grey(value, 1), {0.5f, 0.5f}));
    EXPECT_NEAR(sums.variance(), 14.0 / 12, 1e-6);
    // One sample says nothing of how far it is off, and readers take 0 for a clean pixel.
    sums = PixelSums();
    EXPECT_EQ(sums.variance(), std::numeric_limits<float>::infinity());
    sums.add(at(grey(1, 1), {0.5f, 0.5f}));
    EXPECT_EQ(sums.variance(), std::numeric_limits<float>::infinity());
    EXPECT_EQ(sums.relative_error(), std::numeric_limits<float>::infinity());
}

TEST(Film, ARadianceThatIsNotFiniteCountsAsBlack)
{
    PixelSums sums;
    sums.add(at(grey(NAN, 1), {0.5f, 0.5f}));
    sums.add(at(grey(INFINITY, 1), {0.5f, 0.5f}));
    sums.add(at(grey(3, 1), {0.5f, 0.5f}));
    EXPECT_EQ(sums.beauty(), Vec4f(1, 1, 1, 1));
    EXPECT_EQ(sums.not_finite(), 2) << "and is counted";
}

TEST(Film, WeightsOfAFilterMayBeNegative)
{
    PixelSums sums;
    for (int i = 0; i < 4; ++i) {
        SampleResult s = grey(i == 3 ? 6.0f : 2.0f, 1);
        s.weight = i == 3 ? -1.0f : 1.0f;
        sums.add(s);
    }
    EXPECT_EQ(sums.beauty(), Vec4f(0, 0, 0, 1)) << "(2 + 2 + 2 - 6) / (3 - 1)";
    PixelSums nothing;
    SampleResult lost = grey(1, 1);
    lost.weight = -1;
    nothing.add(lost);
    EXPECT_EQ(nothing.beauty(), Vec4f(0));
}

// The mean weighs samples by signs, so what is equally bright everywhere has no noise, whatever the signs are.
TEST(Film, SignsOfAFilterAreNoNoise)
{
    PixelSums sums;
    for (int i = 0; i < 20; ++i) {
        SampleResult s = grey(0.5f, 1);
        s.weight = i % 10 == 0 ? -1.0f : 1.0f;
        sums.add(s);
    }
    EXPECT_EQ(sums.beauty().x, 0.5f);
    EXPECT_NEAR(sums.variance(), 0, 1e-12);
    EXPECT_NEAR(sums.relative_error(), 0, 1e-6);
}

// The variance of weighted means over many pixels is the mean of what is estimated from the samples of each.
TEST(Film, VarianceIsThatOfTheWeightedMean)
{
    test::Numbers numbers(1);
    test::Mean of_means, estimated;
    double squares = 0;
    constexpr int kPixels = 4000;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        PixelSums sums;
        for (int i = 0; i < 64; ++i) {
            SampleResult s = grey(1 + numbers.one(), 1);
            s.weight = numbers.one() < 0.1f ? -1.0f : 1.0f;
            sums.add(s);
        }
        of_means.add(double(sums.beauty().x));
        squares += double(sums.beauty().x) * double(sums.beauty().x);
        estimated.add(double(sums.variance()));
    }
    const double variance = squares / kPixels - of_means.value() * of_means.value();
    // The variance of so many means is known to within 2.2 % (its standard error is sqrt(2 / 4000) of it), and that of a
    // ratio of sums of 64 samples is a few per cent above its first order.
    EXPECT_NEAR(estimated.value(), variance, 0.15 * variance);
}

// The four samples 1, 2, 3 and 6 have a mean of 3 and a standard error of sqrt(14 / 12).
TEST(Film, TheRelativeErrorIsTheStandardErrorOverTheMean)
{
    PixelSums sums;
    for (float value : {1.0f, 2.0f, 3.0f, 6.0f}) sums.add(grey(value, 1));
    EXPECT_NEAR(sums.relative_error(), std::sqrt(14.0 / 12) / 3, 1e-6);
    EXPECT_TRUE(std::isinf(PixelSums().relative_error()));
}

TEST(Film, StoresInsideTheCropAndKeepsLayersInOrder)
{
    Settings settings;
    settings.width = 8;
    settings.height = 4;
    settings.crop_x0 = 0.5f;
    settings.aovs = Aov::Albedo | Aov::Depth;
    Film film(settings);
    PixelSums sums;
    sums.add(at(grey(1, 7), {0.5f, 0.5f}));
    film.store(5, 3, sums);
    const Image image = std::move(film).take();
    EXPECT_EQ(image.width, 4);
    EXPECT_EQ(image.x0, 4);
    EXPECT_EQ(image.full_width, 8);
    ASSERT_EQ(image.layers().size(), 3u);
    EXPECT_EQ(image.layers()[0].name, "beauty");
    EXPECT_EQ(image.find("depth")->pixels[3 * 4 + 1], 7);
    EXPECT_TRUE(std::isinf(image.find("depth")->pixels[0])) << "what was never reached is a miss";
    EXPECT_EQ(image.find("albedo")->pixels[4 * (3 * 4 + 1) + 1], 0.25f);
    EXPECT_EQ(image.find("normal"), nullptr);
}

TEST(Settings, RefusesWhatIsOutOfRangeByName)
{
    const auto refused = [](auto change) {
        Settings s;
        change(s);
        try {
            check(s);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(refused([](Settings&) {}), "");
    EXPECT_NE(refused([](Settings& s) { s.width = 0; }).find("size"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.width = s.height = 65536; }).find("size"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.crop_x1 = 0; }).find("crop"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.crop_y0 = NAN; }).find("crop"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.spp = 0; }).find("spp"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.shading_rate = NAN; }).find("shading_rate"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.deadline_s = -1; }).find("deadline"), std::string::npos);
    // The clock could not add these to the present.
    EXPECT_NE(refused([](Settings& s) { s.deadline_s = 1e10; }).find("deadline"), std::string::npos);
    EXPECT_NE(refused([](Settings& s) { s.deadline_s = 1e300; }).find("deadline"), std::string::npos);
}

TEST(Settings, ACropHoldsAtLeastOnePixel)
{
    Settings s;
    s.width = 10;
    s.height = 10;
    s.crop_x0 = 0.999f;
    s.crop_y1 = 0.001f;
    const PixelRect r = crop_pixels(s);
    EXPECT_EQ(r, (PixelRect{9, 0, 10, 1}));
}

TEST(Settings, CropsThatMeetAtABorderBetweenPixelsShareNone)
{
    for (const int side : {10, 50, 100, 1280, 1920, 65000})
        for (int part = 0; part < 10; ++part) {
            const float from = static_cast<float>(part) / 10, to = static_cast<float>(part + 1) / 10;
            const int first = side / 10 * part, last = side / 10 * (part + 1);
            EXPECT_EQ(crop_pixels({.width = side, .height = 8, .crop_x0 = from, .crop_x1 = to}),
                      (PixelRect{first, 0, last, 8}));
            EXPECT_EQ(crop_pixels({.width = 8, .height = side, .crop_y0 = from, .crop_y1 = to}),
                      (PixelRect{0, first, 8, last}));
        }
    // A pixel that is in the crop in part is in it.
    EXPECT_EQ(crop_pixels({.width = 100, .height = 8, .crop_x0 = 0.2501f, .crop_x1 = 0.7401f}), (PixelRect{25, 0, 75, 8}));
}

}  // namespace
}  // namespace occam::render
