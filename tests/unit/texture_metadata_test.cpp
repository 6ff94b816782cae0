// Tests of what is removed from image files before a library reads them.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "io/texture/image_metadata.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

std::vector<std::byte> bytes_of(const std::filesystem::path& path)
{
    std::ifstream stream(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}
bool contains(const std::vector<std::byte>& bytes, std::string_view word)
{
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.find(word) != std::string_view::npos;
}

// Writes a ramp with a profile, a description and an author, and returns its path.
std::filesystem::path described(const test::TempFolder& folder, const char* name, int channels)
{
    constexpr int kSide = 8;
    std::vector<unsigned char> pixels;
    for (int i = 0; i < kSide * kSide * channels; ++i) pixels.push_back(static_cast<unsigned char>(3 * i));
    const std::filesystem::path path = folder.path() / name;
    OIIO::ImageSpec spec(kSide, kSide, channels, OIIO::TypeDesc::UINT8);
    const std::string profile = "a colour profile that is none" + std::string(200, '\x7f');
    // libpng would not write this profile.
    if (path.extension() != ".png")
        spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(profile.size())),
                       profile.data());
    spec.attribute("ImageDescription", "a ramp, and nothing else");
    spec.attribute("Artist", "nobody");
    const auto writer = OIIO::ImageOutput::create(path.string());
    if (!writer || !writer->open(path.string(), spec) || !writer->write_image(OIIO::TypeDesc::UINT8, pixels.data()))
        throw std::runtime_error("the image cannot be written");
    writer->close();
    return path;
}

TEST(ImageMetadata, TexelsStayAndProfilesGo)
{
    const test::TempFolder folder;
    const std::pair<const char*, const char*> files[] = {{"a.png", "png"}, {"a.jpg", "jpeg"}, {"a.tif", "tiff"}};
    for (const auto& [name, format] : files) {
        const std::filesystem::path path = described(folder, name, 3);
        const std::vector<std::byte> before = bytes_of(path), after = without_metadata(before, format);
        EXPECT_LE(after.size(), before.size()) << name;
        folder.write(std::string("clean_") + name,
                     std::string_view(reinterpret_cast<const char*>(after.data()), after.size()));
        const auto with = OIIO::ImageInput::open(path.string());
        const auto without = OIIO::ImageInput::open((folder.path() / (std::string("clean_") + name)).string());
        ASSERT_TRUE(with && without) << name;
        const char* described_by = std::string_view(format) == "png" ? "ImageDescription" : "ICCProfile";
        EXPECT_NE(with->spec().find_attribute(described_by), nullptr) << name << ": there is something to take out";
        EXPECT_EQ(without->spec().find_attribute(described_by), nullptr) << name;
        std::vector<unsigned char> a(8 * 8 * 3), b(a);
        ASSERT_TRUE(with->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, a.data())) << name;
        ASSERT_TRUE(without->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, b.data())) << name;
        EXPECT_EQ(a, b) << name;
    }
}

TEST(ImageMetadata, TransparencyOfAPaletteStays)
{
    // The image has one texel, of a palette whose first colour is half transparent.
    const std::string_view png(
        "\x89PNG\r\n\x1a\n"
        "\0\0\0\x0dIHDR\0\0\0\1\0\0\0\1\x08\x03\0\0\0\x28\xcb\x34\xbb"
        "\0\0\0\x03PLTE\xff\0\0\x19\xe2\x09\x37"
        "\0\0\0\x01tRNS\x80\xad\x5e\x5b\x46"
        "\0\0\0\x04tEXtab\0c\0\0\0\0"
        "\0\0\0\0IEND\xae\x42\x60\x82",
        8 + 25 + 15 + 13 + 16 + 12);
    const auto* first = reinterpret_cast<const std::byte*>(png.data());
    const std::vector<std::byte> after = without_metadata({first, png.size()}, "png");
    EXPECT_EQ(after.size(), png.size() - 16);
    EXPECT_TRUE(contains(after, "tRNS"));
    EXPECT_FALSE(contains(after, "tEXt"));
}

TEST(ImageMetadata, WhatIsCutOffIsCopiedAsFarAsItGoes)
{
    const test::TempFolder folder;
    const std::pair<const char*, const char*> files[] = {{"a.jpg", "jpeg"}, {"a.tif", "tiff"}};
    for (const auto& [name, format] : files) {
        const std::vector<std::byte> whole = bytes_of(described(folder, name, 3));
        for (std::size_t size = 0; size < whole.size(); ++size)
            ASSERT_LE(without_metadata(std::span(whole).first(size), format).size(), size) << name;
    }
}

// A directory at byte 8, with a bit for each texel in two bytes behind it.
std::string bilevel_tiff(bool is_little)
{
    std::string file(2, is_little ? 'I' : 'M');
    const auto put = [&](std::size_t value, std::size_t bytes) {
        for (std::size_t i = 0; i < bytes; ++i)
            file += static_cast<char>(value >> 8 * (is_little ? i : bytes - 1 - i) & 0xff);
    };
    put(42, 2), put(8, 4);
    struct Entry {
        std::size_t tag, value;
    };
    constexpr Entry kEntries[] = {{256, 8}, {257, 2}, {262, 1}, {273, 10 + 6 * 12 + 4}, {278, 2}, {279, 2}};
    put(std::size(kEntries), 2);
    for (const Entry& entry : kEntries) put(entry.tag, 2), put(4, 2), put(1, 4), put(entry.value, 4);
    put(0, 4);
    return file + "\xf0\xff";
}

TEST(ImageMetadata, ATiffThatDoesNotNameItsBitsHasOneForATexel)
{
    const test::TempFolder folder;
    for (const bool is_little : {true, false}) {
        const std::string file = bilevel_tiff(is_little);
        const auto* first = reinterpret_cast<const std::byte*>(file.data());
        const std::vector<std::byte> after = without_metadata({first, file.size()}, "tiff");
        const auto path = folder.write("b.tif", {reinterpret_cast<const char*>(after.data()), after.size()});
        const auto image = OIIO::ImageInput::open(path.string());
        ASSERT_TRUE(image) << OIIO::geterror();
        unsigned char texels[16] = {};
        ASSERT_TRUE(image->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT8, texels));
        for (int i = 0; i < 16; ++i) EXPECT_EQ(texels[i], i < 4 || i >= 8 ? 255 : 0) << i;
        EXPECT_EQ(without_metadata(after, "tiff"), after) << "it is there now";
        for (std::size_t size = 0; size < file.size(); ++size) without_metadata({first, size}, "tiff");
    }
}

}  // namespace
}  // namespace occam
