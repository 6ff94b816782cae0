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

std::string big_endian(std::uint32_t value)
{
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
    return bytes;
}

/// Returns a chunk with its checksum (PNG, annex D).
std::string chunk(const std::string& type_and_data)
{
    std::uint32_t crc = ~0u;
    for (const char c : type_and_data) {
        crc ^= static_cast<unsigned char>(c);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return big_endian(static_cast<std::uint32_t>(type_and_data.size() - 4)) + type_and_data + big_endian(~crc);
}

/// Returns bytes as a stream of deflate that stores them (RFC 1950 and 1951).
std::string stored(const std::string& bytes)
{
    std::uint32_t a = 1, b = 0;
    for (const char c : bytes) a = (a + static_cast<unsigned char>(c)) % 65521, b = (b + a) % 65521;
    const auto size = static_cast<unsigned>(bytes.size());
    std::string head("\x78\x01\x01", 3);
    for (const unsigned n : {size, ~size}) head.append({static_cast<char>(n & 0xff), static_cast<char>(n >> 8 & 0xff)});
    return head + bytes + big_endian(b << 16 | a);
}

struct Kind {
    int depth, color, channels;  ///< as in the file
    bool interlaced = false, transparent = false;
};

/// Returns a picture of 13 x 9 pixels with bytes that look random, in a form that Occam does not write.
std::string png_of(const Kind& kind, bool damaged = false)
{
    constexpr int kWide = 13, kHigh = 9;
    std::string values;
    std::uint32_t state = 1;
    const auto add_rows = [&](int wide, int high) {
        for (int y = 0; wide > 0 && y < high; ++y) {
            values += damaged ? '\x55' : static_cast<char>(y % 5);  // the filter
            for (int i = 0; i < (wide * kind.channels * kind.depth + 7) / 8; ++i)
                values += static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
        }
    };
    constexpr int kPasses[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                   {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    if (!kind.interlaced) add_rows(kWide, kHigh);
    else
        for (const auto& [x, y, dx, dy] : kPasses) add_rows((kWide - x + dx - 1) / dx, (kHigh - y + dy - 1) / dy);
    const char head[] = {char(kind.depth), char(kind.color), 0, 0, char(kind.interlaced)};
    std::string file("\x89PNG\r\n\x1a\n", 8);
    file += chunk("IHDR" + big_endian(kWide) + big_endian(kHigh) + std::string(head, 5));
    if (kind.color == 3) {
        std::string palette = "PLTE";
        for (int i = 0; i < 3 << kind.depth; ++i) palette += static_cast<char>(i * 37);
        file += chunk(palette);
    }
    if (kind.transparent)
        file += chunk("tRNS" + (kind.color == 3 ? std::string("\x10\x80\x30", 3)
                                                : std::string(kind.color == 0 ? 2u : 6u, kind.depth == 8 ? '\0' : '\x01')));
    return file + chunk("IDAT" + stored(values)) + chunk("IEND");
}

const Kind kKinds[] = {
    {1, 0, 1},
    {2, 0, 1},
    {4, 0, 1},
    {8, 0, 1},
    {16, 0, 1},
    {8, 2, 3},
    {16, 2, 3},
    {1, 3, 1},
    {2, 3, 1},
    {4, 3, 1},
    {8, 3, 1},
    {8, 4, 2},
    {16, 4, 2},
    {8, 6, 4},
    {16, 6, 4},
    {16, 6, 4, true},
    {4, 3, 1, true, true},
    {8, 3, 1, false, true},
    {8, 0, 1, false, true},
    {16, 2, 3, false, true},
    {8, 2, 3, true, true},
    {1, 0, 1, true, true},
};

TEST(PngFile, AllKindsAreReadAsTheLibraryForAllFormatsReadsThem)
{
    const TempFolder folder;
    for (const Kind& kind : kKinds) {
        const int which = static_cast<int>(&kind - kKinds);
        const fs::path path = folder.write("a.png", png_of(kind));
        std::string why;
        const auto own = open_png(ImageBytes(path), why), other = picture_codec().open(path, why);
        ASSERT_TRUE(own && other) << which << why;
        const PictureSpec &a = own->spec(), &b = other->spec();
        EXPECT_EQ(std::tuple(a.width, a.height, a.type, a.alpha_channel, a.full_width, a.full_height),
                  std::tuple(b.width, b.height, b.type, b.alpha_channel, b.full_width, b.full_height))
            << which;
        ASSERT_EQ(a.channels, b.channels) << which;
        const std::size_t row = std::size_t(a.width) * a.channels.size();
        std::vector<float> floats(row * 9), expected(row * 9);
        std::vector<std::uint8_t> bytes(row * 9), expected_bytes(row * 9);
        ASSERT_TRUE(other->read_rows(0, 9, a.channel_count(), expected.data()));
        for (const auto& [begin, end] : {std::pair(5, 9), {0, 2}, {2, 5}})  // the first comes again after the others
            ASSERT_TRUE(own->read_rows(begin, end, a.channel_count(), &floats[row * std::size_t(begin)])) << own->error();
        EXPECT_EQ(floats, expected) << which;
        if (a.type != SampleType::Byte) continue;
        ASSERT_TRUE(own->read_rows(0, 9, a.channel_count(), bytes.data()));
        ASSERT_TRUE(other->read_rows(0, 9, a.channel_count(), expected_bytes.data()));
        EXPECT_EQ(bytes, expected_bytes) << which;
        std::vector<std::uint8_t> first(13 * 9);
        ASSERT_TRUE(own->read_rows(0, 9, 1, first.data()));
        for (std::size_t i = 0; i < first.size(); ++i) ASSERT_EQ(first[i], bytes[i * a.channels.size()]) << which;
    }
}

TEST(PngFile, DamagedRowsAreAnErrorWithAReason)
{
    for (const Kind& kind : kKinds) {
        const std::string file = png_of(kind, true);
        std::string why;
        const auto reader = open_png(ImageBytes(std::as_bytes(std::span(file))), why);
        ASSERT_TRUE(reader) << why;
        std::vector<float> values(13 * 9 * 4);
        EXPECT_FALSE(reader->read_rows(0, 9, reader->spec().channel_count(), values.data()));
        EXPECT_FALSE(reader->error().empty());
    }
}

// The caller's room is that of the rows as they were declared first.
TEST(PngFile, AFileThatIsReplacedWhileItIsReadIsAnErrorAndNoLongerRow)
{
    const TempFolder folder;
    const auto picture = [](int width) {
        return png({width, 8, 3, true, ""}, std::vector<float>(std::size_t(width) * 8 * 3, 0.5f));
    };
    const std::string narrow = picture(8), wide = picture(60'000);
    const fs::path file = folder.write("a.png", narrow);
    std::string why;
    const auto reader = open_png(ImageBytes(file), why);
    ASSERT_TRUE(reader) << why;
    std::vector<std::uint8_t> values(8 * 8 * 3);
    ASSERT_TRUE(reader->read_rows(0, 8, 3, values.data()));
    folder.write("a.png", wide);
    for (const int begin : {0, 4, 0}) {
        EXPECT_FALSE(reader->read_rows(begin, begin + 2, 3, values.data()));
        EXPECT_EQ(reader->error(), "the file has changed while it was read");
    }
    folder.write("a.png", narrow);
    std::fill(values.begin(), values.end(), std::uint8_t(0));
    EXPECT_TRUE(reader->read_rows(4, 8, 3, values.data())) << "it is the picture again that was opened";
    EXPECT_EQ(values[4 * 8 * 3 - 1], 128);
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
