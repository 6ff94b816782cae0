// Images that declare more than is reasonable, and files that are no images: each is refused by name, before a library
// spends time or memory on it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "io/exr_file.h"
#include "io/texture/decode_budget.h"
#include "io/texture/jpeg_head.h"
#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/support/picture_bytes.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

std::string little_endian(std::uint32_t value, int bytes)
{
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
}

class ImageFiles : public testing::Test {
protected:
    std::vector<std::string> errors_of(const std::string& name, const std::string& content)
    {
        Scene scene;
        Texture texture;
        texture.path = folder_.write(name, content);
        scene.add(std::move(texture));
        TextureStore store(std::size_t(16) << 20);
        store.prepare(scene);
        store.decode_all();
        return store.errors();
    }
    void expect_no_refusal(const std::string& name, const std::string& content)
    {
        for (const std::string& error : errors_of(name, content)) ADD_FAILURE() << error;
    }
    /// Expects one error, which names the file and gives the reason.
    void expect_refusal(const std::string& name, const std::string& content, const std::string& why)
    {
        const std::vector<std::string> errors = errors_of(name, content);
        ASSERT_EQ(errors.size(), 1u) << name;
        EXPECT_NE(errors[0].find(name), std::string::npos) << errors[0];
        EXPECT_NE(errors[0].find(why), std::string::npos) << errors[0];
    }

    /// Returns the red of the four texels of an image of 2 x 2, times 255.
    std::vector<int> reds_of(const std::string& name, const std::string& content)
    {
        Scene scene;
        Texture texture;
        texture.path = folder_.write(name, content);
        texture.role = TextureRole::Data;
        TextureUse use;
        use.texture = scene.add(std::move(texture));
        use.nearest = true;
        TextureStore store(std::size_t(16) << 20);
        store.prepare(scene);
        std::vector<int> found;
        for (const Vec2f at : {Vec2f(0.25f, 0.25f), Vec2f(0.75f, 0.25f), Vec2f(0.25f, 0.75f), Vec2f(0.75f, 0.75f)})
            found.push_back(static_cast<int>(std::lround(255 * store.sample(use, at, 0).x)));
        EXPECT_EQ(store.errors(), std::vector<std::string>{}) << name;
        return found;
    }

private:
    TempFolder folder_;
};

// The extension never decides: a file is read by what it holds.
TEST_F(ImageFiles, OfOtherFormatsAreRefusedWithAListOfThose)
{
    using namespace std::string_literals;
    const std::pair<const char*, std::string> files[] = {
        {"a.null", "x"},
        {"a.txt", "hello world"},
        {"a.png", "hello world"},
        {"empty.jpg", ""},
        {"a.vdb", " BDV"s + std::string(100, '\0')},
        {"a.psd", "8BPS\0\1"s + std::string(100, '\0')},
        {"a.ico", "\0\0\1\0\1\0"s + std::string(100, '\0')},
        {"a.mp4", "\0\0\0\x18"s + "ftypmp42" + std::string(100, '\0')},
        {"a.heic", "\0\0\0\x18"s + "ftypheic" + std::string(100, '\0')},
        {"a.ktx2", "\xabKTX 20\xbb\r\n\x1a\n" + std::string(100, '\0')},
    };
    for (const auto& [name, content] : files) expect_refusal(name, content, "not an image of a format that is read: PNG");
}

std::string segment(int marker, const std::string& data)
{
    const auto size = static_cast<unsigned>(data.size()) + 2;
    return std::string("\xff") + static_cast<char>(marker) + static_cast<char>(size >> 8) + static_cast<char>(size & 0xff) +
           data;
}

/// Returns a progressive JPEG of one component whose scans hold one byte each (ITU T.81, annex B and G).
std::string jpeg(int width, int height, int scans)
{
    const auto word = [](int value) { return std::string{static_cast<char>(value >> 8), static_cast<char>(value & 0xff)}; };
    const std::string table = std::string(1, '\x01') + std::string(15, '\0') + std::string(1, '\0');
    std::string file = "\xff\xd8" + segment(0xdb, std::string(1, '\0') + std::string(64, '\x01')) +
                       segment(0xc2, "\x08" + word(height) + word(width) + std::string("\x01\x01\x11\0", 4)) +
                       segment(0xc4, std::string(1, '\0') + table) + segment(0xc4, "\x10" + table) +
                       segment(0xda, std::string("\x01\x01\0\0\0\0", 6)) + std::string(1, '\0');
    const std::string scan = segment(0xda, std::string("\x01\x01\0\x01\x3f\0", 6)) + std::string(1, '\0');
    for (int i = 1; i < scans; ++i) file += scan;
    return file + "\xff\xd9";
}

TEST_F(ImageFiles, JpegsWithScansBeyondCountingAreRefused)
{
    const std::string ordinary = jpeg(64, 48, 10);
    const auto head = jpeg_head(std::as_bytes(std::span(ordinary)));
    ASSERT_TRUE(head);
    EXPECT_EQ(head->width, 64u);
    EXPECT_EQ(head->height, 48u);
    EXPECT_EQ(head->scans, 10u);
    EXPECT_FALSE(jpeg_head(std::as_bytes(std::span(ordinary).first(2))));
    expect_refusal("many.jpg", jpeg(64, 48, 70'000), "more scans than are read at its size: 70000");
    expect_refusal("large.jpg", jpeg(8000, 8000, 1000), "more scans than are read at its size: 1000");
    expect_refusal("huge.jpg", jpeg(65'500, 65'500, 1), "image is larger than is read: 65500 x 65500");
    expect_refusal("empty.jpg", jpeg(16'000, 8000, 2), "image declares far more than the file holds: 16000 x 8000");
}

TEST_F(ImageFiles, WithHundredsOfChannelsAreReadOnlyIfTheyAreSmall)
{
    using namespace std::string_view_literals;
    PictureSpec spec;
    spec.width = spec.height = spec.full_width = spec.full_height = 4;
    for (int c = 0; c < 1000; ++c) spec.channels.push_back("c" + std::to_string(c));
    BytesInMemory file;
    ASSERT_EQ(write_exr(spec, {}, std::vector<float>(4 * 4 * 1000, 0.5f).data(), file), "");
    constexpr std::string_view kWindow = "dataWindow\0box2i\0"sv;
    const std::int32_t window[] = {0, 0, 1999, 1999};
    std::memcpy(&file.all[file.all.find(kWindow) + kWindow.size() + 4], window, sizeof window);
    expect_refusal("channels.exr", file.all, "more channels than are read at its size: 1000");
}

/// Returns a TIFF of 64 x 64 pixels in one tile of the given side, which is not there.
std::string tiled_tiff(std::uint32_t side)
{
    struct Entry {
        std::uint32_t tag, type, value;
    };
    const Entry entries[] = {{256, 4, 64}, {257, 4, 64},   {258, 3, 8},    {259, 3, 1}, {262, 3, 1},  {277, 3, 1},
                             {284, 3, 1},  {322, 4, side}, {323, 4, side}, {324, 4, 8}, {325, 4, 100}};
    std::string file("II*\0\x08\0\0\0", 8);
    file += little_endian(std::size(entries), 2);
    for (const Entry& e : entries)
        file += little_endian(e.tag, 2) + little_endian(e.type, 2) + little_endian(1, 4) + little_endian(e.value, 4);
    return file + std::string(1000, '\0');
}

TEST_F(ImageFiles, WithTilesOfGibibytesAreRefused)
{
    expect_refusal("tiles.tif", tiled_tiff(16'384), "larger tiles than are read: 16384 x 16384");
    expect_refusal("tiles.tif", tiled_tiff(1 << 16), "larger tiles than are read: 65536 x 65536");
}

// The reader of BMP allocates the whole picture when it opens one with run lengths, and its product of the sides overflows.
TEST_F(ImageFiles, BmpsDeclareTheirSizeBeforeTheyAreOpened)
{
    const auto bmp = [](std::uint32_t width, std::uint32_t height, std::uint32_t bits) {
        return "BM" + little_endian(200, 4) + little_endian(0, 4) + little_endian(118, 4) + little_endian(40, 4) +
               little_endian(width, 4) + little_endian(height, 4) + little_endian(1, 2) + little_endian(bits, 2) +
               little_endian(bits == 4 ? 2 : 1, 4) + std::string(200, '\0');
    };
    expect_refusal("a.bmp", bmp(46'341, 46'341, 4), "image is larger than is read: 46341 x 46341");
    expect_refusal("b.bmp", bmp(30'000, static_cast<std::uint32_t>(-30'000), 8),
                   "image is larger than is read: 30000 x 30000");
    expect_refusal("c.bmp", bmp(16'000, 8000, 8), "image declares far more than the file holds: 16000 x 8000");
}

// Run lengths are of colours in a table, and pixels of 16 bits or more have none: the library looked there nevertheless.
TEST_F(ImageFiles, BmpsOfRunLengthsHaveAsManyBitsAsTheseSay)
{
    const auto bmp = [](std::uint32_t bits, std::uint32_t compression) {
        return "BM" + little_endian(0, 4) + little_endian(0, 4) + little_endian(54 + (bits <= 8 ? 4u << bits : 0), 4) +
               little_endian(40, 4) + little_endian(6, 4) + little_endian(1, 4) + little_endian(1, 2) +
               little_endian(bits, 2) + little_endian(compression, 4) + std::string(20, '\0') +
               std::string(bits <= 8 ? 4u << bits : 0, '\x55') + std::string("\6\2\0\1", 4) + std::string(100, '\0');
    };
    const char* const kWhy = "the image is compressed in a way that is not read";
    for (const std::uint32_t bits : {1u, 4u, 16u, 24u, 32u}) expect_refusal("runs8.bmp", bmp(bits, 1), kWhy);
    for (const std::uint32_t bits : {1u, 8u, 16u, 24u, 32u}) expect_refusal("runs4.bmp", bmp(bits, 2), kWhy);
    for (const std::uint32_t compression : {4u, 5u, 11u, 0xffffffffu}) expect_refusal("c.bmp", bmp(24, compression), kWhy);
    expect_no_refusal("runs8.bmp", bmp(8, 1));
    expect_no_refusal("runs4.bmp", bmp(4, 2));
    for (const std::uint32_t bits : {1u, 4u, 8u, 16u, 24u, 32u}) expect_no_refusal("plain.bmp", bmp(bits, 0));
    expect_no_refusal("masks.bmp", bmp(16, 3));
    expect_refusal("masks.bmp", bmp(32, 3), "the masks of its colours are not of eight bits each");
}

/// Returns a TGA of 2 x 2 pixels that are numbers of colours, of which there are `count` from number `first` on: the red of
/// each is its number.
std::string tga_of_numbers(std::uint32_t first, std::uint32_t count, std::string pixels, std::uint32_t bits = 8)
{
    std::string file = little_endian(0x010100, 3) + little_endian(first, 2) + little_endian(count, 2) +
                       little_endian(24, 1) + little_endian(0, 4) + little_endian(2, 2) + little_endian(2, 2) +
                       little_endian(bits, 1) + little_endian(0x20, 1);
    for (std::uint32_t i = first; i < first + count; ++i) file += little_endian(i << 16, 3);
    return file + pixels;
}
/// Returns the same as a GIF that is not compressed: nine bits for each number.
std::string gif_of_numbers(std::uint32_t log2_of_count, const std::string& pixels, bool is_local)
{
    const std::uint32_t fields = 0x80 | (log2_of_count - 1);
    std::string map;
    for (std::uint32_t i = 0; i < 1u << log2_of_count; ++i) map += little_endian(i, 3);
    std::string file = "GIF89a" + little_endian(2, 2) + little_endian(2, 2) + little_endian(is_local ? 0 : fields, 3);
    if (!is_local) file += map;
    file += std::string("\x21\xfe\1x\0,", 6) + little_endian(0, 4) + little_endian(2, 2) + little_endian(2, 2) +
            little_endian(is_local ? fields : 0, 1);
    if (is_local) file += map;
    std::uint64_t codes = 256, end = 9;
    for (const char pixel : pixels) codes |= std::uint64_t(static_cast<unsigned char>(pixel)) << end, end += 9;
    codes |= std::uint64_t(257) << end;
    file += "\x08\x07";
    for (int k = 0; k < 7; ++k) file += static_cast<char>(codes >> (8 * k));
    return file + std::string("\0;", 2);
}

// The library read what lay in memory behind the colours.
TEST_F(ImageFiles, NumbersWithoutAColourAreBlack)
{
    const std::string pixels("\1\2\xff\3", 4);
    EXPECT_EQ(reds_of("a.tga", tga_of_numbers(0, 3, pixels)), (std::vector<int>{1, 2, 0, 0}));
    EXPECT_EQ(reds_of("b.tga", tga_of_numbers(0, 256, pixels)), (std::vector<int>{1, 2, 255, 3}));
    EXPECT_EQ(reds_of("first.tga", tga_of_numbers(2, 2, pixels)), (std::vector<int>{0, 2, 0, 3}));
    EXPECT_EQ(reds_of("far.tga", tga_of_numbers(65'535, 3, pixels)), (std::vector<int>{0, 0, 0, 0}));
    std::string footer = tga_of_numbers(0, 3, pixels) + std::string("abc", 3) + little_endian(33, 4) + little_endian(0, 4) +
                         std::string("TRUEVISION-XFILE.\0", 18);
    EXPECT_EQ(reds_of("footer.tga", footer), (std::vector<int>{1, 2, 0, 0}));
    for (const bool is_local : {false, true}) {
        EXPECT_EQ(reds_of("a.gif", gif_of_numbers(2, pixels, is_local)), (std::vector<int>{1, 2, 0, 3})) << is_local;
        EXPECT_EQ(reds_of("b.gif", gif_of_numbers(8, pixels, is_local)), (std::vector<int>{1, 2, 255, 3})) << is_local;
    }
    for (const std::uint32_t bits : {15u, 16u, 24u, 32u})
        expect_refusal("wide.tga", tga_of_numbers(0, 3, pixels + pixels + pixels + pixels, bits), "numbers of colours");
    // What is cut off gets one line at most.
    const std::string whole = tga_of_numbers(0, 3, pixels), gif = gif_of_numbers(2, pixels, false);
    for (std::size_t size = 18; size < whole.size(); ++size)
        EXPECT_LE(errors_of("cut.tga", whole.substr(0, size)).size(), 1u);
    for (std::size_t size = 6; size < gif.size(); ++size) EXPECT_LE(errors_of("cut.gif", gif.substr(0, size)).size(), 1u);
}

// The library did not come to an end with one that is a cube map of pixels without bits.
TEST_F(ImageFiles, OfDdsAreFlatAndOfKnownPixels)
{
    const auto dds = [](std::uint32_t flags, std::uint32_t bits, std::uint32_t caps, std::uint32_t more_caps) {
        std::string file = "DDS " + little_endian(124, 4) + little_endian(0x81007, 4) + little_endian(4, 4) +
                           little_endian(4, 4) + little_endian(8, 4) + std::string(52, '\0');
        file += little_endian(32, 4) + little_endian(flags, 4) + "DXT1" + little_endian(bits, 4);
        for (const std::uint32_t mask : {0xffu, 0xff00u, 0xff0000u, 0u}) file += little_endian(mask, 4);
        return file + little_endian(caps, 4) + little_endian(more_caps, 4) + std::string(100, '\0');
    };
    constexpr std::uint32_t kTexture = 0x1000, kComplex = 8, kDxt = 4, kRgb = 0x40;
    const char* const kWhy = "the DDS file is a cube map or a volume";
    expect_refusal("hangs.dds", dds(0x29, 0, 0xffffffff, 0x4cffff), kWhy);
    expect_refusal("cube.dds", dds(kDxt, 0, kTexture | kComplex, 0xfe00), kWhy);
    expect_refusal("volume.dds", dds(kDxt, 0, kTexture | kComplex, 0x200000), kWhy);
    for (const std::uint32_t bits : {0u, 7u, 64u, 0xffffffffu})
        expect_refusal("bits.dds", dds(kRgb, bits, kTexture, 0), kWhy);
    expect_refusal("palette.dds", dds(0x20, 8, kTexture, 0), kWhy);
    for (const std::uint32_t alpha : {1u, 2u}) expect_refusal("masks.dds", dds(kRgb | alpha, 32, kTexture, 0), kWhy);
    expect_no_refusal("dxt.dds", dds(kDxt, 0, kTexture, 0));
    for (const std::uint32_t bits : {24u, 32u}) expect_no_refusal("rgb.dds", dds(kRgb, bits, kTexture, 0));
}

TEST_F(ImageFiles, PngsDeclareTheirSizeBeforeTheyAreOpened)
{
    const auto big = [](std::uint32_t v) {
        const std::string s = little_endian(v, 4);
        return std::string(s.rbegin(), s.rend());
    };
    const std::string file = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) + big(0x7fffffff) + big(1) +
                             std::string("\x08\x06\0\0\0\0\0\0\0", 9) + std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12);
    expect_refusal("wide.png", file, "image is larger than is read: 2147483647 x 1");
}

// Returns a TIFF of four floats a texel whose strips, of one row each, are all the same few bytes of the file. They are not
// compressed, since no test decodes them.
std::string tiff_of_floats(std::uint32_t width, std::uint32_t height)
{
    const std::string strip(64, '\0');
    const std::uint32_t ints = 8 + 64, ifd = ints + 8 * height + 24;
    std::string file = "II" + little_endian(42, 2) + little_endian(ifd, 4) + strip;
    for (std::uint32_t row = 0; row < height; ++row) file += little_endian(8, 4);
    for (std::uint32_t row = 0; row < height; ++row) file += little_endian(64, 4);
    for (const std::uint32_t value : {32u, 3u})
        for (int channel = 0; channel < 4; ++channel) file += little_endian(value, 2);
    file += std::string(ifd - file.size(), '\0');
    const std::uint32_t words = ints + 8 * height;
    const std::uint32_t entries[][4] = {{256, 4, 1, width}, {257, 4, 1, height}, {258, 3, 4, words},
                                        {259, 3, 1, 8},     {262, 3, 1, 2},      {273, 4, height, ints},
                                        {277, 3, 1, 4},     {278, 4, 1, 1},      {279, 4, height, ints + 4 * height},
                                        {284, 3, 1, 1},     {338, 3, 1, 2},      {339, 3, 4, words + 8}};
    file += little_endian(static_cast<std::uint32_t>(std::size(entries)), 2);
    for (const auto& [tag, type, count, value] : entries)
        file += little_endian(tag, 2) + little_endian(type, 2) + little_endian(count, 4) + little_endian(value, 4);
    return file + little_endian(0, 4);
}

// Each of these files is within the limits of one image; together they would take minutes.
TEST(ImagesOfAScene, AreRefusedIfTheyHaveMoreScansThanAreReadForAllOfThem)
{
    const TempFolder folder;
    const std::string file = jpeg(1024, 1024, 1000), ordinary = jpeg(64, 48, 10);
    Scene scene;
    const auto add = [&](const std::string& name, const std::string& content) {
        Texture texture;
        texture.path = folder.write(name, content);
        scene.add(std::move(texture));
    };
    for (int i = 0; i < 6; ++i) add(std::to_string(i) + ".jpg", file);  // 2^32 texels are those of four such files
    add("last.jpg", ordinary);
    TextureStore store(std::size_t(16) << 20);
    store.prepare(scene);
    const std::vector<std::string> errors = store.errors();
    ASSERT_EQ(errors.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NE(errors[i].find(std::to_string(i + 4) + ".jpg"), std::string::npos) << errors[i];
        EXPECT_NE(errors[i].find("more scans than are read for all images of a scene together: 1000"), std::string::npos);
    }
}

TEST(ImagesOfAScene, MayHaveAsManyScansAsLargeFilesHave)
{
    DecodeBudget budget;
    constexpr std::uintmax_t kMegabyte = 1 << 20;
    // Ten scans of 16 million texels in two MB, a thousand times.
    for (int i = 0; i < 1000; ++i) EXPECT_TRUE(budget.takes_scans(160 * kMegabyte, 2 * kMegabyte));
    EXPECT_FALSE(budget.takes_scans(4'000'000 * kMegabyte, kMegabyte));
    EXPECT_TRUE(budget.takes_scans(160 * kMegabyte, 2 * kMegabyte));
}

// Each of these files is within the limits of one image; together they would take minutes.
TEST(ImagesOfAScene, AreRefusedIfTheirFilesHoldFarLessThanIsDecoded)
{
    const TempFolder folder;
    const std::string file = tiff_of_floats(4096, 4096);
    const auto prepare = [&](int count) {
        Scene scene;
        for (int i = 0; i < count; ++i) {
            Texture texture;
            texture.path = folder.write(std::to_string(i) + ".tif", file);
            scene.add(std::move(texture));
        }
        TextureStore store(std::size_t(16) << 20);
        store.prepare(scene);
        EXPECT_EQ(store.errors(), std::vector<std::string>{});
    };
    prepare(16);  // 4 GB
    try {
        prepare(17);
        ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("the images hold 4352 MB of texels"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace occam::test
