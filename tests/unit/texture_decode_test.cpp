// Tests of what becomes of image files as textures: which channels are colours, where the picture lies in its window, which
// way its rows run, and that halved images are whole.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/srgb.h"
#include "io/texture/decode.h"
#include "io/texture/texture_entry.h"
#include "io/texture/texture_store.h"
#include "render/image.h"
#include "scenegraph/scene.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

constexpr std::size_t kPlenty = std::size_t(1) << 30;

Texture texture_of(const std::filesystem::path& path)
{
    Texture texture;
    texture.path = path;
    return texture;
}

// Holds a texture alone in a scene.
struct Loaded {
    Scene scene;
    TextureStore store;
    TextureUse use;

    explicit Loaded(Texture texture, std::size_t cap = kPlenty) : store(cap)
    {
        use.texture = scene.add(std::move(texture));
        use.wrap_s = use.wrap_t = TextureUse::Wrap::Clamp;
        store.prepare(scene);
        store.decode_all();
        for (const std::string& line : store.errors()) ADD_FAILURE() << line;
    }
    explicit Loaded(const std::filesystem::path& path, std::size_t cap = kPlenty) : Loaded(texture_of(path), cap) {}
    Vec4f at(float u, float v) const { return store.sample(use, {u, v}, 0); }
    Vec4f mean() const { return store.sample(use, {0.5f, 0.5f}, 1e6f); }
};

OIIO::ImageSpec floats(int width, int height, std::vector<std::string> channels)
{
    OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = std::move(channels);
    spec.alpha_channel = spec.z_channel = -1;
    for (int c = 0; c < spec.nchannels; ++c) {
        if (spec.channelnames[std::size_t(c)] == "A") spec.alpha_channel = c;
        if (spec.channelnames[std::size_t(c)] == "Z") spec.z_channel = c;
    }
    return spec;
}

std::filesystem::path write(const test::TempFolder& folder, const OIIO::ImageSpec& spec, const std::vector<float>& values)
{
    const std::filesystem::path path = folder.path() / "image.exr";
    const auto writer = OIIO::ImageOutput::create(path.string());
    EXPECT_TRUE(writer && writer->open(path.string(), spec) && writer->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    writer->close();
    return path;
}

// Returns the texel of an OpenEXR file that has the value 1 / 4 in the first channel, 2 / 4 in the second, and so on.
Vec4f texel_of(std::vector<std::string> channels)
{
    const test::TempFolder folder;
    std::vector<float> values;
    for (std::size_t c = 0; c < channels.size(); ++c) values.push_back(0.25f * float(c + 1));
    return Loaded(write(folder, floats(1, 1, std::move(channels)), values)).at(0.5f, 0.5f);
}

// A texture that has only a path is named by it.
TEST(TextureDecode, EveryMessageNamesTheFile)
{
    const test::TempFolder folder;
    const float infinite = std::numeric_limits<float>::infinity();
    OIIO::ImageSpec spec = floats(2, 2, {"R", "G", "B"});
    const auto path = write(folder, spec, {-1, 0, 0, infinite, 0, 0, 0, 0, 0, 0, 0, 0});
    const auto expect_names = [&](const std::vector<std::string>& lines, std::size_t count) {
        EXPECT_EQ(lines.size(), count);
        for (const std::string& line : lines) EXPECT_TRUE(line.starts_with(path.string() + ": ")) << line;
    };
    expect_names(Loaded(path).store.warnings(), 2);

    std::atomic<bool> has_failed = false;
    DecodeBudget budget;
    TextureEntry entry(std::make_shared<const Texture>(texture_of(path)), has_failed, budget);
    write(folder, floats(1, 2, {"R", "G", "B"}), std::vector<float>(6));
    entry.image(MipImage(1, 1));
    expect_names(entry.errors(), 1);
}

TEST(TextureDecode, ChannelsOfOpenExrAreWhatTheirNamesSay)
{
    EXPECT_EQ(texel_of({"R", "G", "B"}), Vec4f(0.25f, 0.5f, 0.75f, 1));
    EXPECT_EQ(texel_of({"R", "G", "B", "A"}), Vec4f(0.25f, 0.5f, 0.75f, 1));
    EXPECT_EQ(texel_of({"R", "G", "B", "Z"}), Vec4f(0.25f, 0.5f, 0.75f, 1)) << "a depth is no alpha";
    EXPECT_EQ(texel_of({"R", "G"}), Vec4f(0.25f, 0.5f, 0, 1)) << "nor is green";
    EXPECT_EQ(texel_of({"G", "B"}), Vec4f(0, 0.25f, 0.5f, 1));
    EXPECT_EQ(texel_of({"Y"}), Vec4f(0.25f, 0.25f, 0.25f, 1));
    EXPECT_EQ(texel_of({"R"}), Vec4f(0.25f, 0.25f, 0.25f, 1));
    EXPECT_EQ(texel_of({"Y", "A"}), Vec4f(0.5f, 0.5f, 0.5f, 0.5f)) << "colours are stored multiplied by alpha";
    EXPECT_EQ(texel_of({"Y", "Z"}), Vec4f(0.25f, 0.25f, 0.25f, 1));
    EXPECT_EQ(texel_of({"paint.R", "paint.G"}), Vec4f(0.25f, 0.5f, 0, 1));
    EXPECT_EQ(texel_of({"N.X", "N.Y", "N.Z"}), Vec4f(0.25f, 0.5f, 0.75f, 1)) << "a vector has three parts";
}

// Files of renderers have many layers, and none of their channels is lost because others come before it. The library sorts
// channels by their names, so these are in its order.
TEST(TextureDecode, ColoursAndAlphaOfOpenExrAreFoundAmongAllChannels)
{
    EXPECT_EQ(texel_of({"UV.U", "UV.V", "rgb.R", "rgb.G", "rgb.B"}), Vec4f(0.75f, 1, 1.25f, 1));
    EXPECT_EQ(texel_of({"Z", "rgb.R", "rgb.G", "rgb.B", "rgb.A"}), Vec4f(Vec3f(0.5f, 0.75f, 1), 1.25f));
    EXPECT_EQ(texel_of({"A", "Z", "rgb.R", "rgb.G", "rgb.B"}), Vec4f(Vec3f(0.75f, 1, 1.25f) / 0.25f, 0.25f))
        << "an alpha without a layer is that of the whole file";
    EXPECT_EQ(texel_of({"R", "G", "B", "mask.A"}), Vec4f(0.25f, 0.5f, 0.75f, 1)) << "a mask is not the alpha of colours";
    EXPECT_EQ(texel_of({"a.A", "b.R", "b.G", "b.B"}), Vec4f(0.5f, 0.75f, 1, 1));
    EXPECT_EQ(texel_of({"a.R", "b.R", "b.G", "b.B", "c.R", "c.G", "c.B"}), Vec4f(0.5f, 0.75f, 1, 1))
        << "colours of one layer belong together";
}

// Programs that crop what is black write a part of the picture and say where it lies.
TEST(TextureDecode, ThePictureOfAnOpenExrFileIsItsDisplayWindow)
{
    const test::TempFolder folder;
    OIIO::ImageSpec spec = floats(2, 1, {"R", "G", "B"});
    spec.x = 11, spec.y = 21;
    spec.full_x = 10, spec.full_y = 20, spec.full_width = 4, spec.full_height = 2;
    const std::vector<float> values = {0.25f, 0.25f, 0.25f, 0.5f, 0.5f, 0.5f};
    {
        const Loaded part(write(folder, spec, values));
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 4; ++x) {
                const float expected = y == 1 && x == 1 ? 0.25f : y == 1 && x == 2 ? 0.5f : 0;
                EXPECT_EQ(part.at((float(x) + 0.5f) / 4, (float(y) + 0.5f) / 2), Vec4f(Vec3f(expected), 1)) << x << ' ' << y;
            }
    }
    spec.full_x = 12, spec.full_y = 21, spec.full_width = 1, spec.full_height = 1;
    EXPECT_EQ(Loaded(write(folder, spec, values)).at(0.1f, 0.1f), Vec4f(Vec3f(0.5f), 1)) << "it holds more than the picture";
    spec.full_x = 500, spec.full_width = 7;
    EXPECT_EQ(Loaded(write(folder, spec, values)).at(0.25f, 0.5f), Vec4f(Vec3f(0.25f), 1)) << "it holds nothing of it";
}

TEST(TextureDecode, ADisplayWindowThatIsFarLargerThanTheFileIsRefused)
{
    const test::TempFolder folder;
    OIIO::ImageSpec spec = floats(1, 1, {"R", "G", "B"});
    spec.full_width = 16384, spec.full_height = 8192;
    EXPECT_THROW(TextureSource(texture_of(write(folder, spec, {0.25f, 0.5f, 0.75f}))), Error);
}

TEST(TextureDecode, RowsOfRadianceFilesRunAsTheySay)
{
    const test::TempFolder folder;
    const auto picture = [&](const std::string& size, const std::string& order) {
        std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n";
        for (const char texel : order) bytes += std::string(3, static_cast<char>((texel - '0') * 32)) + '\x81';
        return folder.write("image.hdr", bytes);
    };
    // Texels are numbered from the top left: 1 2 above 3 4.
    for (const auto& [size, order] : {std::pair<const char*, const char*>{"-Y 2 +X 2", "1234"},
                                      {"+Y 2 +X 2", "3412"},
                                      {"-Y 2 -X 2", "2143"},
                                      {"+Y 2 -X 2", "4321"}}) {
        const Loaded image(picture(size, order));
        for (int k = 0; k < 4; ++k)
            EXPECT_NEAR(image.at(k % 2 == 0 ? 0.1f : 0.9f, k < 2 ? 0.1f : 0.9f).x, float(k + 1) * 0.25f, 0.01f)
                << size << ' ' << k;
    }
}

// The library's own samples would be up to a step of eight bits too dark.
TEST(TextureDecode, SamplesOfPnmFilesAreSharesOfTheirLargest)
{
    const test::TempFolder folder;
    const auto expect = [&](const std::string& bytes, std::initializer_list<float> values) {
        SCOPED_TRACE(bytes);
        Texture texture = texture_of(folder.write("image.ppm", bytes));
        texture.role = TextureRole::Data;
        const TextureSource source(texture);
        const MipImage image = source.decode(0);
        ASSERT_EQ(source.width(), 2);
        int i = 0;
        for (const float value : values) {
            EXPECT_NEAR(image.texel(0, i / 3, 0)[i % 3], value, 5e-4f) << i;
            ++i;
        }
    };
    const float step = 1.0f / 100;
    const std::initializer_list<float> colors = {step, 2 * step, 33 * step, 50 * step, 99 * step, 1};
    expect("P6\n# comment\n2 1 # another\n100\n\x01\x02\x21\x32\x63\x64", colors);
    expect("P6 2 1 100 \x01\x02\x21\x32\x63\xff", colors);
    expect("P3 2 1 100 1 2 33\n50 # comment\n 99 100", colors);
    expect("P5 2 1 3 \x01\x02", {1.0f / 3, 1.0f / 3, 1.0f / 3, 2.0f / 3, 2.0f / 3, 2.0f / 3});
    expect("P2\n2 1\n200\n199 1\n", {199.0f / 200, 199.0f / 200, 199.0f / 200, 1.0f / 200, 1.0f / 200, 1.0f / 200});
    expect("P6 2 1 255 \x33\x66\x99\xcc\xff\x01", {0.2f, 0.4f, 0.6f, 0.8f, 1, 1.0f / 255});
    EXPECT_THROW(
        {
            const TextureSource cut(texture_of(folder.write("cut.ppm", "P6 2 1 100 \x01\x02")));
            cut.decode(0);
        },
        Error);
}

// The tiles do not divide the rows of a halved image, nor these the tiles.
TEST(TextureDecode, HalvesTiledImagesOfAnyTileHeight)
{
    constexpr int kSide = 96;
    const test::TempFolder folder;
    std::vector<float> values;
    for (int i = 0; i < kSide * kSide; ++i) values.push_back(float(i / kSide) / kSide);
    for (const int tile : {3, 20, 48, 64, 100}) {
        OIIO::ImageSpec spec = floats(kSide, kSide, {"Y"});
        spec.tile_width = 16, spec.tile_height = tile, spec.tile_depth = 1;
        const std::filesystem::path path = write(folder, spec, values);
        for (const std::size_t cap : {kPlenty, std::size_t(30'000), std::size_t(6'000), std::size_t(2'500)}) {
            const Loaded image(path, cap);
            EXPECT_LE(image.store.bytes(), cap);
            for (const float v : {0.2f, 0.5f, 0.8f}) EXPECT_NEAR(image.at(0.5f, v).x, v - 0.5f / kSide, 0.002f) << tile;
        }
    }
}

TEST(TextureDecode, AHalvedImageIsWholeWhateverItsSize)
{
    for (const auto& [width, height] : {std::pair(15, 7), {7, 15}, {1000, 3}, {3, 1000}, {255, 257}, {1, 700}}) {
        Texture texture;
        texture.name = "ramp";
        texture.width = width, texture.height = height;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                texture.pixels.emplace_back(float(x) / float(width), float(y) / float(height), 1, 1);
        for (const std::size_t cap : {std::size_t(100'000), std::size_t(4'000), std::size_t(1'000), std::size_t(0)}) {
            const Loaded halved(texture, cap);
            const Vec4f mean = halved.mean();
            EXPECT_NEAR(mean.x, 0.5f * (1 - 1 / float(width)), 0.003f) << width << " x " << height << ", " << cap;
            EXPECT_NEAR(mean.y, 0.5f * (1 - 1 / float(height)), 0.003f) << width << " x " << height << ", " << cap;
            EXPECT_NEAR(mean.z, 1, 1e-3f);
        }
    }
}

TEST(TextureDecode, AWarningCountsHalvings)
{
    const auto warning = [](std::size_t cap) {
        Texture texture;
        texture.name = "grey";
        texture.width = texture.height = 256;
        texture.pixels.assign(std::size_t(256) * 256, Vec4f(0.5f));
        const std::vector<std::string> lines = Loaded(texture, cap).store.warnings();
        return lines.size() == 1 ? lines[0] : std::to_string(lines.size()) + " warnings";
    };
    EXPECT_EQ(warning(600'000), "grey: halved 1 time to fit the texture memory");
    EXPECT_EQ(warning(150'000), "grey: halved 2 times to fit the texture memory");
}

// The pictures are three texels wide and two high: 1 2 3 above 4 5 6. The tag says where the first row and the first column
// of a file lie (TIFF 6.0, sec. 8).
TEST(TextureDecode, RowsOfTiffFilesRunAsTheySay)
{
    const std::pair<int, const char*> files[] = {{1, "123456"}, {2, "321654"}, {3, "654321"}, {4, "456123"},
                                                 {5, "142536"}, {6, "362514"}, {7, "635241"}, {8, "415263"}};
    const test::TempFolder folder;
    for (const auto& [orientation, order] : files)
        for (const char* compression : {"none", "lzw"}) {
            const bool swaps = orientation > 4;
            OIIO::ImageSpec spec(swaps ? 2 : 3, swaps ? 3 : 2, 3, OIIO::TypeDesc::UINT8);
            spec.attribute("Orientation", orientation);
            spec.attribute("compression", compression);
            std::vector<unsigned char> values;
            for (const char* texel = order; *texel; ++texel)
                values.insert(values.end(), 3, static_cast<unsigned char>((*texel - '0') * 40));
            const auto path = folder.path() / "image.tif";
            const auto writer = OIIO::ImageOutput::create(path.string());
            ASSERT_TRUE(writer && writer->open(path.string(), spec) &&
                        writer->write_image(OIIO::TypeDesc::UINT8, values.data()) && writer->close());
            Texture texture = texture_of(path);
            texture.role = TextureRole::Data;
            const TextureSource source(texture);
            ASSERT_EQ(source.width(), 3) << orientation;
            ASSERT_EQ(source.height(), 2) << orientation;
            const MipImage image = source.decode(0);
            const render::Image picture = render::Image::read(path);
            ASSERT_EQ(picture.width, 3) << orientation;
            ASSERT_EQ(picture.height, 2) << orientation;
            for (int i = 0; i < 6; ++i) {
                const float expected = float(i + 1) * 40 / 255;
                EXPECT_NEAR(image.texel(0, i % 3, i / 3).x, expected, 1e-3f) << orientation << ' ' << i;
                EXPECT_NEAR(picture.find("beauty")->pixels[std::size_t(i) * 3], linear_from_srgb(expected), 1e-3f)
                    << orientation << ' ' << i;
            }
            EXPECT_NEAR(source.decode(1).texel(0, 0, 0).x, 3.5f * 40 / 255, 1e-3f) << "a halved image is whole";
        }
}

// Of pixels in YCbCr with fewer samples of Cb and Cr, libtiff itself would turn the rows.
TEST(TextureDecode, RowsOfTiffFilesInYcbcrAreTurnedOnce)
{
    // Two blocks of 2 x 1 texels, one above the other: Y Y Cb Cr.
    std::string file = std::string("II*\0", 4) + std::string("\x10\0\0\0", 4) +
                       std::string("\xc8\xc8\x80\x80\x32\x32\x80\x80", 8);
    const auto put = [&](std::size_t value, std::size_t bytes) {
        for (std::size_t i = 0; i < bytes; ++i) file += static_cast<char>(value >> 8 * i & 0xff);
    };
    struct Entry {
        std::size_t tag, type, count, value;
    };
    constexpr std::size_t kBits = 16 + 2 + 12 * 12 + 4;
    constexpr Entry kEntries[] = {{256, 3, 1, 2}, {257, 3, 1, 2}, {258, 3, 3, kBits}, {259, 3, 1, 1},
                                  {262, 3, 1, 6}, {273, 4, 1, 8}, {274, 3, 1, 4},     {277, 3, 1, 3},
                                  {278, 3, 1, 2}, {279, 4, 1, 8}, {284, 3, 1, 1},     {530, 3, 2, 0x10002}};
    static_assert(std::size(kEntries) == 12);
    put(std::size(kEntries), 2);
    for (const Entry& e : kEntries) put(e.tag, 2), put(e.type, 2), put(e.count, 4), put(e.value, 4);
    put(0, 4);
    for (int i = 0; i < 3; ++i) put(8, 2);
    const test::TempFolder folder;
    const Loaded image(folder.write("y.tif", file));
    EXPECT_LT(image.at(0.5f, 0.1f).x, image.at(0.5f, 0.9f).x) << "the file's first row, which is bright, is the lowest";
}

}  // namespace
}  // namespace occam
