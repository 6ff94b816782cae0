// Image files that are longer than the pictures that they declare can need: each is refused by name, before it is read.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/texture/image_length.h"
#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

using namespace std::string_literals;

std::string little_endian(std::uint64_t value, int bytes)
{
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
}

struct Entry {
    std::uint32_t tag, type, count, value;
};

// Returns the directory of a TIFF that has no samples.
std::string tiff(std::initializer_list<Entry> entries)
{
    std::string file = "II*\0\x08\0\0\0"s + little_endian(entries.size(), 2);
    for (const auto& [tag, type, count, value] : entries)
        file += little_endian(tag, 2) + little_endian(type, 2) + little_endian(count, 4) + little_endian(value, 4);
    return file + little_endian(0, 4);
}

// Returns a TIFF of four doubles a texel, whose bits a sample stand behind its directory.
std::string tiff_of_doubles(std::uint32_t width, std::uint32_t height)
{
    constexpr std::uint32_t kBehind = 8 + 2 + 4 * 12 + 4;
    const std::string bits = little_endian(64, 2);
    return tiff({{256, 4, 1, width}, {257, 4, 1, height}, {258, 3, 4, kBehind}, {277, 3, 1, 4}}) + bits + bits + bits + bits;
}

// Returns the same as a BigTIFF.
std::string big_tiff_of_doubles(std::uint32_t width, std::uint32_t height)
{
    std::string file = "II+\0\x08\0\0\0"s + little_endian(16, 8) + little_endian(4, 8);
    const auto add = [&](std::uint32_t tag, std::uint32_t type, std::uint64_t count, std::uint64_t value) {
        file += little_endian(tag, 2) + little_endian(type, 2) + little_endian(count, 8) + little_endian(value, 8);
    };
    add(256, 4, 1, width);
    add(257, 16, 1, height);
    add(258, 3, 4, 0x0040004000400040);  // four numbers of 16 bits have room in the entry
    add(277, 3, 1, 4);
    return file + little_endian(0, 8);
}

std::string png(std::string_view sides)
{
    return "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"s + std::string(sides) + "\x08\0\0\0\0\0\0\0\0"s;
}

// Returns the head of a JPEG of one component, with a comment before it that holds the mark of a frame.
std::string jpeg(std::string_view sides)
{
    return "\xff\xd8\xff\xfe\0\x08\xff\xc0\0\x0b\x08\0"s + "\xff\xff\xc0\0\x0b\x08"s + std::string(sides) + "\1\1\x11\0"s;
}

// Few bytes on a disk may be such a file. It was read into memory twice or three times before anything looked at its size.
TEST(LongImages, AreRefusedBeforeTheyAreRead)
{
    const TempFolder folder;
    const std::pair<const char*, std::string> heads[] = {
        {"none.tif", "II*\0\x08\0\0\0"s},
        {"none_big.tif", "II+\0\x08\0\0\0\x10\0\0\0\0\0\0\0"s},
        {"doubles.tif", tiff_of_doubles(8, 8)},
        {"none.jpg", "\xff\xd8\xff"s},
        {"a.jpg", jpeg("\0\x40\0\x40"s)},
        {"a.png", png("\0\0\0\1\0\0\0\1"s)},
        {"a.gif", "GIF89a\2\0\2\0"s},
        {"numbers.tga", "\0\1\1\0\0\1\0\x18\0\0\0\0\2\0\2\0\x08\0"s},
        {"dxt2.dds", "DDS "s + std::string(76, '\1') + "\4\0\0\0DXT2"s},
        {"few.pgm", "P5 2 2 9\n"s},
    };
    for (const auto& [name, head] : heads) {
        Scene scene;
        Texture texture;
        texture.path = folder.write(name, head);
        std::filesystem::resize_file(texture.path, std::uintmax_t(1536) << 20);
        scene.add(std::move(texture));
        TextureStore store(std::size_t(16) << 20);
        const auto start = std::chrono::steady_clock::now();
        store.prepare(scene);
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3)) << name;
        const std::vector<std::string> errors = store.errors();
        ASSERT_EQ(errors.size(), 1u) << name;
        EXPECT_NE(errors[0].find("longer than is read for the image that it declares: 1536 MB"), std::string::npos)
            << errors[0];
    }
}

TEST(LongImages, MayBeAsLongAsTheirPicturesNeed)
{
    constexpr ImageLimits kLimits = {16384, std::uintmax_t(1) << 27, std::uintmax_t(1) << 29, std::uintmax_t(1) << 29};
    const auto megabytes = [&](std::string_view format, const std::string& head) {
        ImageBytes bytes(std::as_bytes(std::span(head)));
        return (most_bytes_of_file(bytes, format, kLimits) - kMostBytesBesidePicture) >> 20;
    };
    EXPECT_EQ(megabytes("tiff", tiff_of_doubles(1024, 1024)), 2u * 32);
    EXPECT_EQ(megabytes("tiff", big_tiff_of_doubles(1024, 1024)), 2u * 32);
    EXPECT_EQ(megabytes("tiff", tiff_of_doubles(16384, 8192)), 2u * 4096);
    EXPECT_EQ(megabytes("tiff", tiff_of_doubles(0xffffffff, 0xffffffff)), 2u * 4096) << "no larger one is read";
    EXPECT_EQ(megabytes("tiff", tiff({{256, 3, 1, 8192}, {257, 3, 1, 8192}})), 2u * 8) << "of one bit a texel";
    EXPECT_EQ(megabytes("jpeg", jpeg("\x10\0\x20\0"s)), 8u * 32);
    EXPECT_EQ(megabytes("png", png("\0\0\x10\0\0\0\x20\0"s)), 2u * 256);
    EXPECT_EQ(megabytes("gif", "GIF89a\0\x10\0\x20"s), 2u * 32);
    EXPECT_EQ(megabytes("targa", "\0\1\1\0\0\1\0\x18\0\0\0\0\0\x10\0\x20\x08\0"s), 2u * 32);
    EXPECT_EQ(megabytes("pnm", "P3 # colours\n4096 4096\n9\n"s), 4u * 48);
}

}  // namespace
}  // namespace occam::test
