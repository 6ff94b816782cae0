// Tests of what is removed from image files before a library reads them.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <vector>

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

std::vector<std::byte> without_metadata(std::span<const std::byte> file, std::string_view format)
{
    std::vector<std::byte> left(file.begin(), file.end());
    remove_metadata(left, format);
    return left;
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

// Writes numbers of a TIFF or of a BigTIFF.
struct TiffWriter {
    bool is_little, is_big;
    std::string file{};

    void put(std::size_t value, std::size_t bytes)
    {
        for (std::size_t i = 0; i < bytes; ++i)
            file += static_cast<char>(value >> 8 * (is_little ? i : bytes - 1 - i) & 0xff);
    }
    std::size_t word() const { return is_big ? 8 : 4; }
    void head(std::size_t directory)
    {
        file.assign(2, is_little ? 'I' : 'M');
        put(is_big ? 43 : 42, 2);
        if (is_big) put(8, 2), put(0, 2);
        put(directory, word());
    }
    // Each entry is a tag and a number of 32 bits, or of 64 in a BigTIFF.
    void directory(const std::vector<std::pair<std::size_t, std::size_t>>& entries)
    {
        put(entries.size(), is_big ? 8 : 2);
        for (const auto& [tag, value] : entries) put(tag, 2), put(is_big ? 16 : 4, 2), put(1, word()), put(value, word());
        put(0, word());
    }
    std::size_t directory_bytes(std::size_t entries) const { return (is_big ? 8 : 2) + entries * (4 + 2 * word()) + word(); }
    std::size_t head_bytes() const { return is_big ? 16 : 8; }
    std::span<const std::byte> bytes() const { return {reinterpret_cast<const std::byte*>(file.data()), file.size()}; }
};

// Returns a directory behind the head, with a bit for each texel in two bytes behind it.
TiffWriter bilevel_tiff(bool is_little, bool is_big)
{
    TiffWriter tiff{is_little, is_big};
    tiff.head(tiff.head_bytes());
    tiff.directory({{256, 8}, {257, 2}, {262, 1}, {273, tiff.head_bytes() + tiff.directory_bytes(6)}, {278, 2}, {279, 2}});
    tiff.file += "\xf0\xff";
    return tiff;
}

constexpr std::pair<bool, bool> kTiffs[] = {{true, false}, {false, false}, {true, true}, {false, true}};

TEST(ImageMetadata, ATiffThatDoesNotNameItsBitsHasOneForATexel)
{
    const test::TempFolder folder;
    for (const auto& [is_little, is_big] : kTiffs) {
        const TiffWriter tiff = bilevel_tiff(is_little, is_big);
        const std::vector<std::byte> after = without_metadata(tiff.bytes(), "tiff");
        const auto path = folder.write("b.tif", {reinterpret_cast<const char*>(after.data()), after.size()});
        const auto image = OIIO::ImageInput::open(path.string());
        ASSERT_TRUE(image) << OIIO::geterror();
        unsigned char texels[16] = {};
        ASSERT_TRUE(image->read_image(0, 0, 0, 1, OIIO::TypeDesc::UINT8, texels));
        for (int i = 0; i < 16; ++i) EXPECT_EQ(texels[i], i < 4 || i >= 8 ? 255 : 0) << i;
        EXPECT_EQ(without_metadata(after, "tiff"), after) << "it is there now";
        for (std::size_t size = 0; size < tiff.file.size(); ++size) without_metadata(tiff.bytes().first(size), "tiff");
    }
}

// The pixels are before the directory, and each two bytes of them are the tag of a profile or of a text.
TEST(ImageMetadata, PixelsThatAreLikeTagsStay)
{
    for (const std::size_t value : {700, 33723, 34377, 34665, 34675, 37724})
        for (const auto& [is_little, is_big] : kTiffs) {
            constexpr std::size_t kSide = 32, kBytes = 2 * kSide * kSide;
            TiffWriter tiff{is_little, is_big};
            tiff.head(tiff.head_bytes() + kBytes);
            for (std::size_t i = 0; i < kSide * kSide; ++i) tiff.put(value, 2);
            tiff.directory({{256, kSide},
                            {257, kSide},
                            {258, 16},
                            {262, 1},
                            {273, tiff.head_bytes()},
                            {278, kSide},
                            {279, kBytes},
                            {34675, 0}});
            const std::vector<std::byte> after = without_metadata(tiff.bytes(), "tiff");
            ASSERT_EQ(after.size(), tiff.file.size());
            const auto pixels = [&](std::span<const std::byte> file) {
                const auto part = file.subspan(tiff.head_bytes(), kBytes);
                return std::vector<std::byte>(part.begin(), part.end());
            };
            EXPECT_EQ(pixels(after), pixels(tiff.bytes())) << value << is_little << is_big;
            std::size_t changed = 0;
            for (std::size_t i = 0; i < after.size(); ++i) changed += after[i] != tiff.bytes()[i];
            EXPECT_EQ(changed, 2u) << "the tag of the profile";
        }
}

TEST(ImageMetadata, TiffsOfOtherVersionsAreLeftAlone)
{
    TiffWriter tiff = bilevel_tiff(true, false);
    tiff.file[2] = 44;
    const std::vector<std::byte> after = without_metadata(tiff.bytes(), "tiff");
    EXPECT_TRUE(std::equal(after.begin(), after.end(), tiff.bytes().begin(), tiff.bytes().end()));
}

}  // namespace
}  // namespace occam
