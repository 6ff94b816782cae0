// Tests of PNG files: what is written is what was meant, and heads of broken files are refused.
#include "io/png_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "render/image.h"
#include "tests/support/picture_bytes.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;

std::string png(const PngPicture& picture, const std::vector<float>& values)
{
    BytesInMemory bytes;
    EXPECT_EQ(write_png(picture, values.data(), bytes), "");
    return bytes.all;
}

std::optional<PngPicture> head_of(const std::string& file)
{
    ImageBytes bytes(std::as_bytes(std::span(file)));
    return read_png_head(bytes);
}

/// Reads all bytes of a picture back through the library for all formats.
std::vector<std::uint8_t> values_of(const fs::path& file, int channels)
{
    std::string why;
    const auto read = picture_codec().open(file, why);
    if (!read || read->spec().channel_count() != channels) return {};
    std::vector<std::uint8_t> values(std::size_t(read->spec().width) * std::size_t(read->spec().height) *
                                     std::size_t(channels));
    if (!read->read_rows(0, read->spec().height, channels, values.data())) return {};
    return values;
}

TEST(PngFile, KeepsEachByteAndRoundsToTheNearest)
{
    const TempFolder folder;
    // Each byte exactly, and a little above and below the middle between two.
    std::vector<float> values;
    std::vector<std::uint8_t> expected;
    for (int byte = 0; byte < 256; ++byte)
        for (const float part : {0.0f, 0.49f, -0.49f}) {
            values.push_back((static_cast<float>(byte) + part) / 255);
            expected.push_back(static_cast<std::uint8_t>(byte));
        }
    for (int channels = 3; channels <= 4; ++channels) {
        const PngPicture picture{16, 768 / 16 / channels, channels, true, ""};
        EXPECT_EQ(values_of(folder.write("a.png", png(picture, values)), channels), expected) << channels;
    }
}

TEST(PngFile, ValuesOutsideOfTheRangeAreClamped)
{
    const TempFolder folder;
    constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();
    const std::string file = png({2, 1, 3, true, ""}, {-1, 2, kInf, -kInf, kNan, 1e30f});
    EXPECT_EQ(values_of(folder.write("a.png", file), 3), (std::vector<std::uint8_t>{0, 255, 255, 0, 0, 255}));
}

TEST(PngFile, TheHeadHoldsSizeColourSpaceAndDescription)
{
    const std::string note = "a note of Occam";
    for (const bool is_srgb : {true, false}) {
        const auto head = head_of(png({5, 3, 4, is_srgb, note}, std::vector<float>(60, 0.5f)));
        ASSERT_TRUE(head);
        EXPECT_EQ(head->width, 5);
        EXPECT_EQ(head->height, 3);
        EXPECT_EQ(head->channels, 4);
        EXPECT_EQ(head->is_srgb, is_srgb);
        EXPECT_EQ(head->description, note);
    }
}

TEST(PngFile, AHeadThatIsCutOffOrChangedIsNoneOrAnother)
{
    const std::string whole = png({5, 3, 3, true, "note"}, std::vector<float>(45, 0.5f));
    const std::size_t head = whole.find("IDAT");
    ASSERT_NE(head, std::string::npos);
    for (std::size_t size = 0; size < head; ++size) EXPECT_FALSE(head_of(whole.substr(0, size))) << size;
    for (std::size_t at = 0; at < head; ++at)
        for (const char bits : {'\x01', '\x80', '\xff'}) {
            std::string changed = whole;
            changed[at] = static_cast<char>(changed[at] ^ bits);
            head_of(changed);  // must come back; checksums refuse most of them
        }
}

TEST(PngFile, PicturesThatAreCutOffAreSaidToBe)
{
    const TempFolder folder;
    render::Image image(40, 30);
    image.add_layer("beauty", {"R", "G", "B"}, false);
    for (const char* const name : {"a.png", "a.exr"}) {
        const fs::path file = folder.path() / name;
        image.write(file, {.note = "a note"});
        const render::PictureHead head = render::Image::read_head(file);
        EXPECT_EQ(head.width, 40);
        EXPECT_EQ(head.height, 30);
        EXPECT_EQ(head.note, "a note");
        const auto size = fs::file_size(file);
        for (const std::uintmax_t left : {size - 1, size / 2, size / 8, std::uintmax_t(9)}) {
            fs::resize_file(file, left);
            EXPECT_THROW(render::Image::read_head(file), Error) << name << ", " << left << " of " << size << " bytes";
        }
    }
}

}  // namespace
}  // namespace occam::test
