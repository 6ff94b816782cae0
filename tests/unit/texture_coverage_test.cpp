// Tests of one picture whose alpha is below 1, in every format that holds it: as a texture and as a picture that is compared
// it is the same, whether a file stores its colours multiplied by alpha or not.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/srgb.h"
#include "io/texture/decode.h"
#include "io/texture/tiled_file.h"
#include "render/image.h"
#include "tests/support/temp_folder.h"
#include "tests/support/webp_files.h"

namespace occam {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureSide = 2;
constexpr float kHalfStep = 1.0f / 2048;

// The products with alpha are whole numbers, so eight bits keep the colours also in files that multiply them. Nothing
// remains of the last colour in these.
constexpr unsigned char kCodes[16] = {200, 100, 50, 51, 255, 0, 85, 255, 150, 250, 0, 102, 70, 80, 90, 0};

std::string number(std::size_t value, std::size_t bytes)
{
    std::string all;
    for (std::size_t i = 0; i < bytes; ++i) all += static_cast<char>(value >> 8 * i & 0xff);
    return all;
}

std::string numbers(std::initializer_list<std::size_t> values)
{
    std::string all;
    for (const std::size_t value : values) all += number(value, 4);
    return all;
}

// Pixels of blue, green, red and alpha, whose rows may begin at the bottom.
std::string bgra(bool begins_below)
{
    std::string all;
    for (std::size_t i = 0; i < 4; ++i) {
        const unsigned char* const c = &kCodes[4 * (begins_below ? (i + 2) % 4 : i)];
        for (const std::size_t k : {2u, 1u, 0u, 3u}) all += static_cast<char>(c[k]);
    }
    return all;
}

std::string bmp()
{
    return "BM" + number(138, 4) + number(0, 4) + number(122, 4) + numbers({108, kPictureSide, kPictureSide}) +
           number(1, 2) + number(32, 2) + numbers({3, 16, 0, 0, 0, 0, 0xff0000, 0xff00, 0xff, 0xff000000}) +
           std::string(52, '\0') + bgra(true);
}

std::string dds(const std::string& pixel_format, const std::string& pixels)
{
    return "DDS " + numbers({124, 0x1007, kPictureSide, kPictureSide, 16, 0, 0}) + std::string(44, '\0') + pixel_format +
           numbers({0x1000, 0, 0, 0, 0}) + pixels;
}

std::string dds() { return dds(numbers({32, 0x41, 0, 32, 0xff0000, 0xff00, 0xff, 0xff000000}), bgra(false)); }

// A block of 4 x 4 texels of one colour, of five and six bits, the first two with alpha 3 and 15 of 15 and the others 0.
std::string dds_of_blocks(const std::string& kind, std::size_t color)
{
    return dds(numbers({32, 4}) + kind + numbers({0, 0, 0, 0, 0}), numbers({0xf3, 0, color << 16 | color, 0}));
}

enum class Stored { Apart, Multiplied };

// Has the library write the picture. A TIFF says whether its colours are multiplied by alpha.
fs::path written(const fs::path& file, OIIO::TypeDesc type, Stored stored = Stored::Apart)
{
    OIIO::ImageSpec spec(kPictureSide, kPictureSide, 4, type);
    if (stored == Stored::Apart) spec.attribute("oiio:UnassociatedAlpha", 1);
    const bool is_real = (type == OIIO::TypeDesc::HALF || type == OIIO::TypeDesc::FLOAT);
    std::vector<float> values;
    for (std::size_t i = 0; i < std::size(kCodes); ++i) {
        const float code = float(kCodes[i]) / 255, alpha = float(kCodes[i | 3]) / 255;
        values.push_back(i % 4 == 3 ? code : (is_real ? linear_from_srgb(code) : code));
        // What is not covered keeps its colour, though usual programs would store 0.
        if (i % 4 != 3 && stored == Stored::Multiplied && alpha > 0) values.back() *= alpha;
    }
    const auto writer = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(writer && writer->open(file.string(), spec) && writer->write_image(OIIO::TypeDesc::FLOAT, values.data()) &&
                writer->close());
    return file;
}

// Has the library write a TGA, whose extension area then says that colours are multiplied, and so are the pixels.
fs::path multiplied_tga(const fs::path& file)
{
    written(file, OIIO::TypeDesc::UINT8);
    std::ifstream stream(file, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t footer = bytes.size() - 26;
    std::size_t area = 0;
    for (std::size_t k = 4; k-- > 0;) area = area << 8 | static_cast<unsigned char>(bytes[footer + k]);
    bytes[area + 494] = 4;
    constexpr std::size_t kHead = 18;
    bytes[2] = 2;  // not compressed, with rows that begin at the bottom
    bytes[17] = 8;
    std::string pixels = bgra(true);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const auto alpha = static_cast<unsigned char>(pixels[i | 3]), code = static_cast<unsigned char>(pixels[i]);
        if (i % 4 != 3 && alpha > 0) pixels[i] = static_cast<char>(code * alpha / 255);
    }
    EXPECT_GE(area, kHead + pixels.size());
    std::ofstream(file, std::ios::binary) << bytes.replace(kHead, pixels.size(), pixels);
    return file;
}

MipImage decoded(const fs::path& file, TextureRole role = TextureRole::Color)
{
    Texture texture;
    texture.path = file;
    texture.role = role;
    return TextureSource(texture).decode(0);
}

// hidden   Multiplied: the file holds light beside an alpha of 0, as light that covers nothing, and the picture keeps it
void expect_picture(const fs::path& file, float tolerance, Stored hidden = Stored::Apart)
{
    SCOPED_TRACE(file.filename().string());
    const MipImage texels = decoded(file);
    const render::Image picture = render::Image::read(file);
    ASSERT_EQ(picture.width, kPictureSide);
    const render::Layer& beauty = *picture.find("beauty");
    ASSERT_EQ(beauty.channel_count(), 4u);
    for (std::size_t i = 0; i < std::size(kCodes); ++i) {
        const std::size_t p = i / 4, c = i % 4;
        const float code = float(kCodes[i]) / 255, alpha = float(kCodes[i | 3]) / 255;
        const float wanted = c == 3 ? code : linear_from_srgb(code);
        const Vec4f texel = texels.texel(0, int(p % kPictureSide), int(p / kPictureSide));
        EXPECT_NEAR(texel[int(c)], wanted, tolerance) << "of the texture, " << i;
        const float share = hidden == Stored::Multiplied && alpha == 0 ? 1 : alpha;
        EXPECT_NEAR(beauty.pixels[i], c == 3 ? code : wanted * share, tolerance) << "of the picture, " << i;
    }
}

TEST(TextureCoverage, APictureIsTheSameInAllFormatsThatHoldIt)
{
    const test::TempFolder folder;
    const fs::path& at = folder.path();
    expect_picture(folder.write("apart.webp", test::kWebpFile), kHalfStep);
    expect_picture(folder.write("apart.bmp", bmp()), kHalfStep);
    expect_picture(folder.write("apart.dds", dds()), kHalfStep);
    expect_picture(written(at / "apart.png", OIIO::TypeDesc::UINT8), kHalfStep);
    expect_picture(written(at / "apart16.png", OIIO::TypeDesc::UINT16), kHalfStep);
    expect_picture(written(at / "apart.tga", OIIO::TypeDesc::UINT8), kHalfStep);
    for (const Stored stored : {Stored::Apart, Stored::Multiplied})
        for (const auto& [name, type] : {std::pair("8.tif", OIIO::TypeDesc::UINT8),
                                         {"16.tif", OIIO::TypeDesc::UINT16},
                                         {"half.tif", OIIO::TypeDesc::HALF},
                                         {"float.tif", OIIO::TypeDesc::FLOAT}})
            expect_picture(
                written(at / ((stored == Stored::Apart ? "apart" : "multiplied") + std::string(name)), type, stored),
                2 * kHalfStep, (type == OIIO::TypeDesc::HALF || type == OIIO::TypeDesc::FLOAT) ? stored : Stored::Apart);
    expect_picture(multiplied_tga(at / "multiplied.tga"), kHalfStep);
    expect_picture(written(at / "multiplied.exr", OIIO::TypeDesc::HALF, Stored::Multiplied), 2 * kHalfStep,
                   Stored::Multiplied);
}

TEST(TextureCoverage, ATiledFileKeepsTheTexelsOfItsImage)
{
    const test::TempFolder folder;
    const MipImage image = decoded(folder.write("image.webp", test::kWebpFile));
    TiledFile::write(image, TextureRole::Color, folder.path() / "image.tx");
    const MipImage tiled = decoded(folder.path() / "image.tx");
    for (int i = 0; i < 4; ++i) EXPECT_EQ(tiled.texel(0, i % 2, i / 2), image.texel(0, i % 2, i / 2)) << i;
    expect_picture(folder.path() / "image.tx", kHalfStep);
}

// What a normal map or a roughness has beside it is no coverage.
TEST(TextureCoverage, DataAreNotDivided)
{
    const test::TempFolder folder;
    for (const char* name : {"data.tif", "data.exr"}) {
        const fs::path file = written(folder.path() / name, OIIO::TypeDesc::FLOAT, Stored::Multiplied);
        EXPECT_NEAR(decoded(file, TextureRole::Data).texel(0, 0, 0).x, linear_from_srgb(200.0f / 255) * 0.2f, kHalfStep);
    }
}

TEST(TextureCoverage, AnAnimatedWebpIsItsFirstFrame)
{
    const test::TempFolder folder;
    const MipImage image = decoded(folder.write("image.webp", test::kWebpAnimation));
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(image.texel(0, i % 2, i / 2).x, linear_from_srgb(float(kCodes[4 * i]) / 255), kHalfStep) << i;
    EXPECT_EQ(image.texel(0, 1, 1).w, 0);
}

// Where a block is multiplied by an alpha of 0, the library for all formats would divide by it, and the process would end.
TEST(TextureCoverage, BlocksOfADdsAreDividedByAnAlphaThatIsNotZero)
{
    const test::TempFolder folder;
    constexpr std::size_t kGrey = 3 << 11 | 6 << 5 | 3;
    const MipImage apart = decoded(folder.write("apart.dds", dds_of_blocks("DXT3", kGrey))),
                   multiplied = decoded(folder.write("multiplied.dds", dds_of_blocks("DXT2", kGrey)));
    const float code = 25.0f / 255;  // as the library rounds it
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(apart.texel(0, i % 2, i / 2).x, linear_from_srgb(code), kHalfStep) << i;
        EXPECT_EQ(multiplied.texel(0, i % 2, i / 2).w, apart.texel(0, i % 2, i / 2).w) << i;
        EXPECT_NEAR(multiplied.texel(0, i % 2, i / 2).x, linear_from_srgb(i == 0 ? 5 * code : code), 4 * kHalfStep) << i;
    }
}

}  // namespace
}  // namespace occam
