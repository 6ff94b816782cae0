// Tests that pictures of few bytes that are compared cannot take gigabytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/texture/open_image.h"
#include "render/image.h"
#include "render/picture_formats.h"
#include "tests/support/temp_folder.h"

namespace occam::render {
namespace {

// Writes a picture of 64 x 64 pixels that are black or all different.
std::filesystem::path written_noise_or_black(const test::TempFolder& folder, const std::string& name, bool is_black)
{
    Image image(64, 64);
    std::uint32_t random = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B"}).pixels) {
        random = random * 1664525 + 1013904223;
        value = is_black ? 0 : static_cast<float>(random >> 8) / float(1 << 24);
    }
    image.write(folder.path() / name, {.exposure_ev = 0.0f, .tonemap = Tonemap::None});
    return folder.path() / name;
}

std::string error_of_few_bytes(const std::filesystem::path& file, std::uintmax_t values_of_few_bytes)
{
    try {
        open_image(file, nullptr, file.string(), {100, 10'000, 100'000, values_of_few_bytes});
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(PictureMemory, FewBytesAreNotManyValues)
{
    const test::TempFolder folder;
    constexpr std::uintmax_t kFour = 64 * 64 * 4;  // a pixel of three values counts as four
    for (const std::string format : {"png", "exr"}) {
        const auto black = written_noise_or_black(folder, "black." + format, true),
                   full = written_noise_or_black(folder, "full." + format, false);
        ASSERT_LT(std::filesystem::file_size(black), kFour / 16) << format;
        EXPECT_EQ(error_of_few_bytes(black, kFour), "") << format;
        EXPECT_NE(error_of_few_bytes(black, kFour - 1).find("image has more values than are read from a file of "),
                  std::string::npos)
            << format;
        EXPECT_EQ(error_of_few_bytes(full, kFour - 1), "") << format << ": it has more bytes";
    }
}

// Each value takes four bytes in two pictures, four more while one of them is read, and perhaps two in the file. A map of
// the differences has three values a pixel, twice while it is written.
TEST(PictureMemory, TwoPicturesOfFewBytesTakeLessThanFourGigabytes)
{
    constexpr std::uintmax_t kMega = 1'000'000, kValues = kReadLimits.values_of_few_bytes;
    EXPECT_LT(kValues * (4 + 4 + 4 + 2), 4000 * kMega);
    EXPECT_LT(kValues * (4 + 4) + kValues / 4 * 3 * (4 + 4), 4000 * kMega);
    EXPECT_GT(kReadLimits.values / 16, 10 * kMega) << "which more values need";
}

TEST(PictureMemory, ManyLayersAreReadSomeRowsAtATime)
{
    const test::TempFolder folder;
    Image image(3, 600);
    for (const std::string name : {"beauty", "albedo", "depth"}) {
        Layer& layer = image.add_layer(
            name, name == "depth" ? std::vector<std::string>{"Z"} : std::vector<std::string>{"R", "G", "B"}, true);
        for (std::size_t i = 0; i < layer.pixels.size(); ++i)
            layer.pixels[i] = static_cast<float>(i) + static_cast<float>(name.size()) / 16;
    }
    image.write(folder.path() / "a.exr", {.half = false});
    const Image read = Image::read(folder.path() / "a.exr");
    for (const Layer& layer : image.layers()) {
        const Layer* const found = read.find(layer.name);
        ASSERT_TRUE(found && found->pixels.size() == layer.pixels.size()) << layer.name;
        const auto value = [&](const Layer& of, std::size_t pixel, const std::string& channel) {
            const auto at = std::find(of.channels.begin(), of.channels.end(), channel);
            return of.pixels[pixel * of.channel_count() + std::size_t(at - of.channels.begin())];
        };
        for (std::size_t pixel = 0; pixel < 1800; ++pixel)
            for (const std::string& channel : layer.channels)
                ASSERT_EQ(value(*found, pixel, channel), value(layer, pixel, channel)) << layer.name << " " << pixel;
    }
}

}  // namespace
}  // namespace occam::render
