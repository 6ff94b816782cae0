// Tests of the OpenEXR files that are written and read without the library that knows all formats: what that library reads
// and writes decides what is right.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>
#include <ImfTiledOutputFile.h>
#include <ImfVersion.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <sstream>

#include "io/exr_file.h"
#include "tests/support/picture_bytes.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

PictureSpec spec_of(int width, int height, std::vector<std::string> channels, std::vector<SampleType> types)
{
    PictureSpec spec;
    spec.width = width, spec.height = height;
    spec.x = 3, spec.y = -5;
    spec.full_width = width + 8, spec.full_height = height + 1;
    spec.channels = std::move(channels);
    spec.channel_types = std::move(types);
    return spec;
}

std::string exr(const PictureSpec& spec, const std::vector<float>& pixels, const std::vector<PictureAttribute>& attributes)
{
    test::BytesInMemory bytes;
    EXPECT_EQ(write_exr(spec, attributes, pixels.data(), bytes), "");
    return bytes.all;
}

std::optional<ExrHead> head_of(const fs::path& file)
{
    ImageBytes bytes(file);
    return read_exr_head(bytes);
}

std::string bytes_of(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<float> noise(std::size_t count)
{
    std::vector<float> values;
    std::uint32_t state = 1;
    for (std::size_t i = 0; i < count; ++i)
        values.push_back(float(state = state * 1664525u + 1013904223u) * 0x1p-31f - 0.5f);
    return values;
}

// Some blocks of such pictures can be compressed and some cannot.
TEST(ExrFile, TheLibraryReadsWhatIsWritten)
{
    const TempFolder folder;
    for (const int height : {1, 16, 17, 150}) {
        constexpr int kWidth = 37;
        const PictureSpec spec = spec_of(
            kWidth, height, {"R", "G", "B", "A", "depth.Z"},
            {SampleType::Float, SampleType::Half, SampleType::Half, SampleType::Half, SampleType::Float});
        const std::vector<float> random = noise(std::size_t(kWidth * height));
        std::vector<float> pixels;
        for (int i = 0; i < kWidth * height; ++i)
            pixels.insert(pixels.end(), {i < 600 ? 0.25f : random[std::size_t(i)], float(i % 500) / 8, -0.5f,
                                         i % 2 ? 1.0f : 0.0f, std::numeric_limits<float>::infinity()});
        const auto path = folder.write("a.exr", exr(spec, pixels, {}));
        std::string why;
        const auto read = picture_codec().open(path, why);
        ASSERT_TRUE(read) << why;
        const PictureSpec& found = read->spec();
        EXPECT_EQ(found.width, kWidth);
        EXPECT_EQ(found.height, height);
        EXPECT_EQ(found.x, 3);
        EXPECT_EQ(found.y, -5);
        EXPECT_EQ(found.full_width, kWidth + 8);
        ASSERT_EQ(found.channels.size(), 5u);
        std::vector<float> back(pixels.size());
        ASSERT_TRUE(read->read_rows(0, height, 5, back.data())) << read->error();
        for (std::size_t c = 0; c < 5; ++c) {
            const auto as = std::find(spec.channels.begin(), spec.channels.end(), found.channels[c]) - spec.channels.begin();
            for (std::size_t i = 0; i < pixels.size(); i += 5) ASSERT_EQ(back[i + c], pixels[i + std::size_t(as)]) << i;
        }
        const auto head = head_of(path);
        ASSERT_TRUE(head);
        EXPECT_EQ(head->width, kWidth);
        EXPECT_EQ(head->height, height);
        EXPECT_EQ(head->channel_count, 5);
    }
}

// Returns the type and the bytes of each attribute of a file's header.
std::map<std::string, std::string> attributes_of(const std::string& file)
{
    Imf::StdISStream stream;
    stream.str(file);
    const Imf::InputFile input(stream, 0);
    std::map<std::string, std::string> found;
    for (auto a = input.header().begin(); a != input.header().end(); ++a) {
        Imf::StdOSStream bytes;
        a.attribute().writeValueTo(bytes, Imf::EXR_VERSION);
        found[a.name()] = std::string(a.attribute().typeName()) + ": " + bytes.str();
    }
    return found;
}

TEST(ExrFile, HasTheAttributesAndPixelsOfAFileThatTheLibraryForAllFormatsWrites)
{
    const std::array<float, 16> matrix{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    const std::array<float, 8> colors{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    PictureSpec spec = spec_of(20, 40, {"R", "G", "B", "A", "id.R"},
                               {SampleType::Half, SampleType::Half, SampleType::Half, SampleType::Half, SampleType::Float});
    spec.alpha_channel = 3;
    const std::vector<float> pixels = noise(20 * 40 * 5);
    std::vector<PictureAttribute> attributes{
        {"occam:note", std::string("some text")}, {"worldToCamera", matrix}, {"chromaticities", colors}, {"answer", 42}};
    attributes.push_back({"expTime", 0.5f});
    const std::string own = exr(spec, pixels, attributes);
    attributes.back().name = "ExposureTime";
    attributes.push_back({"compression", std::string("zip")});
    test::BytesInMemory other;
    ASSERT_EQ(picture_codec().write("a.exr", spec, attributes, pixels.data(), other), "");
    auto expected = attributes_of(other.all);
    expected.erase("capDate");  // that library adds the date if it is not given; the command gives it
    EXPECT_EQ(attributes_of(own), expected);
    const TempFolder folder;
    std::string why;
    const auto a = picture_codec().open(folder.write("a.exr", own), why);
    const auto b = picture_codec().open(folder.write("b.exr", other.all), why);
    std::vector<float> of_a(pixels.size()), of_b(pixels.size());
    ASSERT_TRUE(a && b && a->read_rows(0, 40, 5, of_a.data()) && b->read_rows(0, 40, 5, of_b.data())) << why;
    EXPECT_EQ(a->spec().channels, b->spec().channels);
    EXPECT_EQ(of_a, of_b);
}

TEST(ExrFile, HalvesAreRoundedToTheNearest)
{
    const TempFolder folder;
    const std::vector<float> values{0.1f,    1e-7f,  65504,   65519,   65521, -1e9f, -std::numeric_limits<float>::infinity(),
                                    2.0005f, 1e-30f, 6.1e-5f, 3.0e-6f, -0.0f};
    const std::vector<float> nearest{
        0.0999755859375f,       1.1920928955078125e-07f, 65504, 65504, INFINITY, -INFINITY, -INFINITY, 2, 0,
        6.097555160522461e-05f, 2.9802322387695312e-06f, 0};
    const auto path = folder.write("a.exr", exr(spec_of(int(values.size()), 1, {"Y"}, {SampleType::Half}), values, {}));
    const auto read = open_exr(ImageBytes(path));
    ASSERT_TRUE(read);
    std::vector<float> back(values.size());
    ASSERT_TRUE(read->read_rows(0, 1, 1, back.data()));
    EXPECT_EQ(back, nearest);
    const std::vector<float> nan{std::numeric_limits<float>::quiet_NaN()};
    const auto other = folder.write("b.exr", exr(spec_of(1, 1, {"Y"}, {SampleType::Half}), nan, {}));
    const auto of_nan = open_exr(ImageBytes(other));
    ASSERT_TRUE(of_nan && of_nan->read_rows(0, 1, 1, back.data()));
    EXPECT_TRUE(std::isnan(back[0]));
}

TEST(ExrFile, NamesMayBeLong)
{
    const TempFolder folder;
    const std::string name = "layer_of_a_name_that_is_longer_than_thirty_one_letters.R";
    const auto path = folder.write("a.exr", exr(spec_of(2, 2, {name}, {SampleType::Float}), {1, 2, 3, 4}, {}));
    std::string why;
    const auto read = picture_codec().open(path, why);
    ASSERT_TRUE(read) << why;
    EXPECT_EQ(read->spec().channels.at(0), name);
}

TEST(ExrFile, WhatTheLibraryRefusesToWriteIsAnError)
{
    test::BytesInMemory bytes;
    const std::vector<float> pixels(4);
    const PictureSpec spec = spec_of(2, 2, {"Y"}, {SampleType::Float});
    const std::vector<PictureAttribute> of_another_type{{"compression", std::string("zip")}};
    EXPECT_NE(write_exr(spec, of_another_type, pixels.data(), bytes), "");
}

TEST(ExrFile, AHeadThatIsCutOffIsNone)
{
    const TempFolder folder;
    const std::string whole = exr(spec_of(4, 4, {"R", "G"}, {SampleType::Float, SampleType::Half}), std::vector<float>(32),
                                  {});
    const std::size_t head = whole.find("screenWindowWidth");
    for (std::size_t size = 0; size < head; size += 7)
        EXPECT_FALSE(head_of(folder.write("a.exr", whole.substr(0, size)))) << size;
    EXPECT_FALSE(head_of(folder.path() / "none.exr"));
}

// A picture that the library itself writes, for the reader.
struct Made {
    std::vector<std::string> channels{"R", "G", "B", "A"};
    std::vector<Imf::PixelType> types = std::vector<Imf::PixelType>(4, Imf::HALF);
    Imf::Compression compression = Imf::ZIP_COMPRESSION;
    Imf::LineOrder order = Imf::INCREASING_Y;
    unsigned tile = 0;  ///< 0: scanlines
    Imf::LevelMode levels = Imf::ONE_LEVEL;
    int sampling = 1;
};
constexpr int kMadeWidth = 70, kMadeHeight = 90;

fs::path make(const fs::path& file, const Made& made)
{
    using Imath::V2i;
    const Imath::Box2i data(V2i(-4, 6), V2i(-4 + kMadeWidth - 1, 6 + kMadeHeight - 1));
    Imf::Header header(Imath::Box2i(V2i(0, 0), V2i(99, 99)), data, 1, {0, 0}, 1, made.order, made.compression);
    std::vector<float> values = noise(std::size_t(kMadeWidth) * kMadeHeight * made.channels.size());
    std::vector<half> halves(values.begin(), values.end());
    std::vector<unsigned> integers(values.size(), 7);
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < made.channels.size(); ++c) {
        const Imf::PixelType type = made.types[c];
        header.channels().insert(made.channels[c], Imf::Channel(type, made.sampling, made.sampling));
        const std::size_t first = c * std::size_t(kMadeWidth) * kMadeHeight;
        const void* const from = type == Imf::HALF    ? static_cast<const void*>(&halves[first])
                                 : type == Imf::FLOAT ? static_cast<const void*>(&values[first])
                                                      : &integers[first];
        buffer.insert(made.channels[c], Imf::Slice::Make(type, from, data, 0, 0, made.sampling, made.sampling));
    }
    if (made.tile == 0) {
        Imf::OutputFile output(file.c_str(), header, 0);
        output.setFrameBuffer(buffer);
        output.writePixels(kMadeHeight);
    } else {
        header.setTileDescription(Imf::TileDescription(made.tile, made.tile / 2, made.levels));
        Imf::TiledOutputFile output(file.c_str(), header, 0);
        output.setFrameBuffer(buffer);
        output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    }
    return file;
}

const Made kPlain[] = {
    {},
    {.channels = {"R", "G", "B"}, .types = {Imf::FLOAT, Imf::FLOAT, Imf::FLOAT}},
    {.channels = {"B", "G", "R"}, .types = {Imf::FLOAT, Imf::HALF, Imf::FLOAT}, .compression = Imf::PIZ_COMPRESSION},
    {.channels = {"Y"}, .types = {Imf::HALF}, .compression = Imf::DWAB_COMPRESSION},
    {.compression = Imf::NO_COMPRESSION, .order = Imf::DECREASING_Y},
    {.compression = Imf::B44_COMPRESSION, .tile = 32},
    {.types = std::vector<Imf::PixelType>(4, Imf::FLOAT), .order = Imf::RANDOM_Y, .tile = 50},
    {.tile = 32, .levels = Imf::MIPMAP_LEVELS},
};

TEST(ExrFile, PlainPicturesAreReadAsTheLibraryForAllFormatsReadsThem)
{
    const TempFolder folder;
    for (const Made& made : kPlain) {
        const std::size_t index = std::size_t(&made - kPlain), channels = made.channels.size(), row = kMadeWidth * channels;
        const fs::path path = make(folder.path() / "a.exr", made);
        std::string why;
        const auto own = open_exr(ImageBytes(path)), other = picture_codec().open(path, why);
        ASSERT_TRUE(own && other) << index << why;
        EXPECT_EQ(own->format(), other->format());
        const PictureSpec &a = own->spec(), &b = other->spec();
        EXPECT_EQ(a.channels, b.channels) << index;
        EXPECT_EQ(a.type, b.type) << index;
        EXPECT_EQ(a.alpha_channel, b.alpha_channel) << index;
        EXPECT_EQ(a.tile_height, b.tile_height) << index;
        EXPECT_EQ(std::tuple(a.x, a.y, a.width, a.height, a.depth), std::tuple(b.x, b.y, b.width, b.height, b.depth))
            << index;
        EXPECT_EQ(std::tuple(a.full_x, a.full_y, a.full_width, a.full_height),
                  std::tuple(b.full_x, b.full_y, b.full_width, b.full_height));
        for (std::size_t c = 0; c < channels; ++c) EXPECT_EQ(a.channel_type(c), b.channel_type(c)) << index;
        std::vector<float> of_own(row * kMadeHeight), of_other(of_own.size());
        ASSERT_TRUE(other->read_rows(0, kMadeHeight, int(channels), of_other.data())) << other->error();
        for (const auto& [begin, end] : {std::pair(40, kMadeHeight), {0, 17}, {17, 40}})
            ASSERT_TRUE(own->read_rows(begin, end, int(channels), &of_own[row * std::size_t(begin)])) << own->error();
        EXPECT_EQ(of_own, of_other) << index;
        std::vector<float> first(std::size_t(kMadeWidth) * kMadeHeight);
        ASSERT_TRUE(own->read_rows(0, kMadeHeight, 1, first.data()));
        for (std::size_t i = 0; i < first.size(); ++i) ASSERT_EQ(first[i], of_other[i * channels]) << index;
    }
}

TEST(ExrFile, OtherPicturesAreLeftToTheLibraryForAllFormats)
{
    const TempFolder folder;
    const std::vector<Imf::PixelType> three(3, Imf::HALF);
    for (const Made& made :
         {Made{.channels = {"R", "G", "B"}, .types = {Imf::UINT, Imf::UINT, Imf::UINT}},
          Made{.channels = {"R", "G", "depth"}, .types = three}, Made{.channels = {"RY", "BY", "Y"}, .types = three},
          Made{.channels = {"a.R", "a.G", "a.B"}, .types = three}, Made{.tile = 32, .levels = Imf::RIPMAP_LEVELS},
          Made{.tile = 1024}, Made{.channels = {"R", "G", "B"}, .types = three, .sampling = 2}})
        EXPECT_FALSE(open_exr(ImageBytes(make(folder.path() / "a.exr", made)))) << made.channels[2];
    OIIO::ImageSpec spec(8, 8, 3, OIIO::TypeDesc::HALF);
    const std::string path = (folder.path() / "parts.exr").string();
    std::vector<OIIO::ImageSpec> parts(2, spec);
    parts[0].attribute("oiio:subimagename", "one"), parts[1].attribute("oiio:subimagename", "two");
    const auto output = OIIO::ImageOutput::create(path);
    const std::vector<float> pixels(8 * 8 * 3);
    ASSERT_TRUE(output && output->open(path, 2, parts.data()) && output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
    ASSERT_TRUE(output->open(path, parts[1], OIIO::ImageOutput::AppendSubimage));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) && output->close());
    EXPECT_FALSE(open_exr(ImageBytes(path)));
    ImageBytes bytes(path);
    EXPECT_FALSE(is_cut_off_exr(bytes));
    EXPECT_TRUE(read_exr_head(bytes));
    EXPECT_FALSE(open_exr(ImageBytes(folder.path() / "none.exr")));
    EXPECT_FALSE(open_exr(ImageBytes(folder.write("empty.exr", ""))));
}

// Reads all rows of what opens, and returns whether all were read.
bool is_readable(std::string_view file)
{
    constexpr std::int64_t kMostTexels = 1 << 20;
    ImageBytes bytes(std::as_bytes(std::span(file)));
    const auto head = read_exr_head(bytes);
    if (!head || std::int64_t(head->width) * head->height > kMostTexels) return false;
    const auto read = open_exr(std::move(bytes));
    if (!read) return false;
    const PictureSpec& spec = read->spec();
    std::vector<float> rows(std::size_t(spec.width) * std::size_t(spec.height) * spec.channels.size());
    const bool is_read = read->read_rows(0, spec.height, spec.channel_count(), rows.data());
    EXPECT_EQ(is_read, read->error().empty());
    return is_read;
}

TEST(ExrFile, PicturesThatAreCutOffOrDamagedAreErrors)
{
    const TempFolder folder;
    for (const std::size_t index : {0u, 2u, 3u, 5u}) {
        const std::string whole = bytes_of(make(folder.path() / "a.exr", kPlain[index]));
        ASSERT_TRUE(is_readable(whole));
        for (std::size_t size = 0; size < whole.size(); size += 97 + size / 8)
            EXPECT_FALSE(is_readable(whole.substr(0, size)));
        // Most of the damage is in the header and the table of chunks. Some of it changes texels alone.
        std::uint32_t state = 1;
        for (int i = 0; i < 400; ++i) {
            std::string damaged = whole;
            const std::size_t reach = i % 4 == 0 ? whole.size() : std::min<std::size_t>(whole.size(), 700);
            state = state * 1664525u + 1013904223u;
            damaged[(state >> 8) % reach] ^= static_cast<char>(1 << (state & 7));
            state = state * 1664525u + 1013904223u;
            if (i % 3 == 0) damaged[(state >> 8) % reach] = i % 2 ? char(0x7f) : char(0xff);
            is_readable(damaged);
        }
    }
}

}  // namespace
}  // namespace occam
