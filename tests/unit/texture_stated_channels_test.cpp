// Tests of what image files say of their channels and a library does not heed: where alpha is and whether there is one,
// which byte is red, and what value is white.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/srgb.h"
#include "io/texture/decode.h"
#include "render/image.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

std::string number(std::size_t value, std::size_t bytes)
{
    std::string all;
    for (std::size_t i = 0; i < bytes; ++i) all += static_cast<char>(value >> 8 * i & 0xff);
    return all;
}
std::string numbers(std::initializer_list<std::size_t> values, std::size_t bytes = 4)
{
    std::string all;
    for (const std::size_t value : values) all += number(value, bytes);
    return all;
}

struct Decoded {
    std::vector<Vec4f> texels;
    bool has_alpha = false;
    std::string error;
};

// Writes a file and reads the texels of its first row.
Decoded decoded(const std::string& name, const std::string& bytes, TextureRole role = TextureRole::Data)
{
    const test::TempFolder folder;
    Texture texture;
    texture.role = role;
    texture.path = folder.write(name, bytes);
    Decoded result;
    try {
        const TextureSource source(texture);
        const MipImage image = source.decode(0);
        for (int x = 0; x < image.width(); ++x) result.texels.push_back(image.texel(0, x, 0));
        result.has_alpha = source.has_alpha();
    } catch (const Error& error) {
        result.error = error.what();
    }
    return result;
}

// Values are bytes, so the tolerance is less than half a step of them.
void expect_near(Vec4f found, Vec4f wanted)
{
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found[k], wanted[k], 1.0f / 512) << k;
}

constexpr Vec4f kRed(1, 0, 0, 1), kGreen(0, 1, 0, 1);

// A BMP of one red pixel and one green one. `masks` are of red, green, blue and alpha; without them there is no compression.
std::string bmp(const std::vector<std::size_t>& masks, const std::string& pixels)
{
    std::string list;
    for (const std::size_t mask : masks) list += number(mask, 4);
    list.resize(masks.empty() ? 0 : 68);
    return "BM" + number(54 + list.size() + 8, 4) + number(0, 4) + number(54 + list.size(), 4) +
           numbers({40 + list.size(), 2, 1}) + number(1, 2) + number(32, 2) +
           numbers({masks.empty() ? 0u : 3u, 8, 0, 0, 0, 0}) + list + pixels;
}

TEST(StatedChannels, MasksOfABmpSayWhichByteIsWhat)
{
    struct Case {
        std::vector<std::size_t> masks;
        std::string pixels;
    };
    const std::string x(1, '\x40'), z(1, '\0'), f(1, '\xff');
    for (const Case& c :
         {Case{{}, z + z + f + z + z + f + z + z}, Case{{0xff0000, 0xff00, 0xff, 0}, z + z + f + x + z + f + z + x},
          Case{{0xff, 0xff00, 0xff0000, 0}, f + z + z + x + z + f + z + x},
          Case{{0xff000000, 0xff0000, 0xff00, 0xff}, f + z + z + f + f + z + f + z},
          Case{{0xff000000, 0xff0000, 0xff00, 0}, x + z + z + f + x + z + f + z}}) {
        const Decoded image = decoded("a.bmp", bmp(c.masks, c.pixels));
        ASSERT_EQ(image.texels.size(), 2u) << image.error;
        EXPECT_EQ(image.has_alpha, !c.masks.empty() && c.masks[3] != 0);
        expect_near(image.texels[0], kRed);
        expect_near(image.texels[1], kGreen);
    }
    const Decoded with_alpha = decoded("a.bmp", bmp({0xff0000, 0xff00, 0xff, 0xff000000}, z + z + f + x + z + f + z + x));
    expect_near(with_alpha.texels.at(0), Vec4f(1, 0, 0, 64.0f / 255));
    // Masks count only where the compression says so.
    std::string without_masks = bmp({1, 2, 4, 0xff000000}, z + z + f + z + z + f + z + z);
    without_masks[30] = 0;
    const Decoded plain = decoded("a.bmp", without_masks);
    ASSERT_EQ(plain.texels.size(), 2u) << plain.error;
    EXPECT_FALSE(plain.has_alpha);
    expect_near(plain.texels[0], kRed);
    EXPECT_NE(
        decoded("a.bmp", bmp({0x3ff00000, 0xffc00, 0x3ff, 0}, std::string(8, '\0'))).error.find("masks of its colours"),
        std::string::npos);
}

TEST(StatedChannels, ATgaSaysWhetherItHasAlpha)
{
    const auto tga = [](char alpha_bits, int kind) {
        std::string file = number(0x20000, 5) + std::string(7, '\0') + numbers({2, 1}, 2) + '\x20' +
                           char(0x20 | alpha_bits) + std::string("\0\0\xff\0\0\xff\0\x80", 8);
        if (kind < 0) return file;
        const std::size_t area = file.size();
        return file + number(495, 2) + std::string(492, '\0') + char(kind) + number(area, 4) + number(0, 4) +
               std::string("TRUEVISION-XFILE.\0", 18);
    };
    for (const auto& [file, has_alpha] : {std::pair(tga(0, -1), false),
                                          {tga(8, -1), true},
                                          {tga(8, 0), false},
                                          {tga(8, 1), false},
                                          {tga(8, 3), true},
                                          {tga(0, 3), false}}) {
        const Decoded image = decoded("a.tga", file);
        ASSERT_EQ(image.texels.size(), 2u) << image.error;
        EXPECT_EQ(image.has_alpha, has_alpha);
        expect_near(image.texels[0], has_alpha ? Vec4f(1, 0, 0, 0) : kRed);
        expect_near(image.texels[1], has_alpha ? Vec4f(0, 1, 0, 128.0f / 255) : kGreen);
    }
}

// A TIFF of one row: tags and their values of 16 bits, of which those that are many stand behind the pixels.
struct Tiff {
    std::size_t width, kind, bits;
    std::vector<std::size_t> extra;  // what samples that are no colours are
    std::size_t samples;             // of a pixel
    std::string pixels;
    std::size_t format = 1;  // 3: numbers with a point
};

std::string tiff(const Tiff& of)
{
    const auto& [width, kind, bits, extra, samples, pixels, format] = of;
    constexpr std::size_t kEntries = 11, kPixelsAt = 8 + 2 + 12 * kEntries + 4;
    const std::size_t lists_at = kPixelsAt + pixels.size();
    std::string lists;
    const auto entry = [&](std::size_t tag, const std::vector<std::size_t>& values) {
        std::string list;
        for (const std::size_t value : values) list += number(value, 2);
        const std::size_t at = lists_at + lists.size();
        if (list.size() > 4) lists += list;
        list.resize(4);
        return number(tag, 2) + number(3, 2) + number(values.size(), 4) + (values.size() > 2 ? number(at, 4) : list);
    };
    std::string file = "II*" + std::string(1, '\0') + number(8, 4) + number(kEntries, 2);
    file += entry(256, {width}) + entry(257, {1}) + entry(258, std::vector<std::size_t>(samples, bits)) + entry(259, {1});
    file += entry(262, {kind}) + entry(273, {kPixelsAt}) + entry(277, {samples}) + entry(278, {1}) +
            entry(279, {pixels.size()});
    file += samples > (kind == 2 ? 3u : kind == 5 ? 4u : 1u) ? entry(338, extra) : entry(296, {1});
    file += entry(339, std::vector<std::size_t>(samples, format));
    return file + number(0, 4) + pixels + lists;
}

TEST(StatedChannels, WhiteMayBeZeroInATiffOfAnyDepth)
{
    for (const std::size_t bits : {8u, 16u, 32u}) {
        const std::string ones(bits / 8, '\xff'), zeros(bits / 8, '\0');
        const Decoded image = decoded("a.tif", tiff({2, 0, bits, {}, 1, ones + zeros}), TextureRole::Color);
        ASSERT_EQ(image.texels.size(), 2u) << image.error;
        expect_near(image.texels[0], Vec4f(0, 0, 0, 1));
        expect_near(image.texels[1], Vec4f(1));
    }
    const test::TempFolder folder;
    const auto file = folder.write("a.tif", tiff({2, 0, 16, {}, 1, std::string("\0\0\xff\xff", 4)}));
    EXPECT_EQ(render::Image::read(file).find("beauty")->pixels[0], 1) << "of a picture that is compared, too";
}

TEST(StatedChannels, ATiffNamesItsAlphaAmongItsSamples)
{
    const auto alpha_of = [](std::size_t kind, const std::vector<std::size_t>& extra, const std::string& pixel) {
        const Decoded image = decoded("a.tif", tiff({1, kind, 8, extra, pixel.size(), pixel}), TextureRole::Color);
        return image.texels.empty() ? Vec4f(-1) : image.texels[0];
    };
    expect_near(alpha_of(2, {2}, "\xff\1\1\x33"), Vec4f(1, 0, 0, 0.2f));
    expect_near(alpha_of(2, {0, 2}, "\xff\1\1\x33\x66"), Vec4f(1, 0, 0, 0.4f));
    expect_near(alpha_of(2, {0, 1}, "\x33\1\1\x33\x66"), Vec4f(linear_from_srgb(0.5f), 0, 0, 0.4f));
    expect_near(alpha_of(1, {0, 2}, "\xff\x33\x66"), Vec4f(1, 1, 1, 0.4f));
    expect_near(alpha_of(1, {0, 0}, "\xff\x33\x66"), Vec4f(1));
}

TEST(StatedChannels, TiffFilesThatWouldBeReadWronglyAreRefused)
{
    const auto error = [](const std::string& file) { return decoded("a.tif", file).error; };
    EXPECT_NE(error(tiff({1, 1, 64, {}, 1, std::string(8, '\0'), 3})).find("more than 32 bits"), std::string::npos);
    EXPECT_NE(error(tiff({1, 5, 8, {2}, 5, std::string(5, '\x70')})).find("four inks"), std::string::npos);
    EXPECT_EQ(error(tiff({1, 5, 8, {}, 4, std::string(4, '\x70')})), "");
    EXPECT_NE(error(tiff({1, 8, 8, {}, 3, std::string(3, '\x70')})).find("CIELab"), std::string::npos);
}

// A block of BC5 has two halves as the alpha of DXT5: two values, and for each texel which of them it is.
TEST(StatedChannels, TwoChannelsOfADdsAreThoseOfANormal)
{
    const std::string block = "\xc8\xc8" + std::string(6, '\0') + "\x64\x64" + std::string(6, '\0');
    const auto dds = [&](const std::string& kind, const std::string& more) {
        return "DDS " + numbers({124, 0x1007, 4, 4, 16, 0, 0}) + std::string(44, '\0') + numbers({32, 4}) + kind +
               numbers({0, 0, 0, 0, 0, 0x1000, 0, 0, 0, 0}) + more + block;
    };
    const float x = 200.0f / 255, y = 100.0f / 255, a = 2 * x - 1, b = 2 * y - 1;
    for (const std::string& file : {dds("ATI2", ""), dds("BC5U", ""), dds("DX10", numbers({83, 3, 0, 1, 0}))}) {
        const Decoded normal = decoded("a.dds", file);
        ASSERT_EQ(normal.texels.size(), 4u) << normal.error;
        expect_near(normal.texels[0], Vec4f(x, y, 0.5f + 0.5f * std::sqrt(1 - a * a - b * b), 1));
        EXPECT_FALSE(normal.has_alpha);
        expect_near(decoded("a.dds", file, TextureRole::Color).texels[0],
                    Vec4f(linear_from_srgb(x), linear_from_srgb(y), 0, 1));
    }
}

}  // namespace
}  // namespace occam
