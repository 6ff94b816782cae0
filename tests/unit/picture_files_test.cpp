// Tests of the picture files that are read and written without the library that knows all formats: what that library reads
// decides what is right.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io/exr_file.h"
#include "io/radiance_file.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

using test::TempFolder;

class Bytes final : public PictureBytes {
public:
    std::string all;
    void write_at(const void* bytes, std::size_t size, std::uint64_t offset) noexcept override
    {
        if (all.size() < offset + size) all.resize(offset + size);
        std::copy_n(static_cast<const char*>(bytes), size, all.begin() + std::ptrdiff_t(offset));
    }
    std::size_t read_at(void*, std::size_t, std::uint64_t) const noexcept override { return 0; }
    std::uint64_t size() const noexcept override { return all.size(); }
};

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
    Bytes bytes;
    write_exr(spec, attributes, pixels.data(), bytes);
    return bytes.all;
}

// Some blocks of such pictures can be compressed and some cannot.
TEST(ExrFile, TheLibraryReadsWhatIsWritten)
{
    const TempFolder folder;
    for (const int height : {1, 16, 17, 50}) {
        constexpr int kWidth = 37;
        const PictureSpec spec = spec_of(
            kWidth, height, {"R", "G", "B", "A", "depth.Z"},
            {SampleType::Float, SampleType::Half, SampleType::Half, SampleType::Half, SampleType::Float});
        std::vector<float> pixels;
        std::uint32_t noise = 1;
        for (int i = 0; i < kWidth * height; ++i) {
            noise = noise * 1664525u + 1013904223u;
            pixels.insert(pixels.end(), {i < 600 ? 0.25f : float(noise) * 0x1p-32f, float(i) / 8, -0.5f, i % 2 ? 1.0f : 0.0f,
                                         std::numeric_limits<float>::infinity()});
        }
        const std::string bytes = exr(spec, pixels, {{"comments", std::string("some text")}, {"expTime", 0.5f}});
        const auto path = folder.write("a.exr", bytes);
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
        const auto head = read_exr_head(path);
        ASSERT_TRUE(head);
        EXPECT_EQ(head->width, kWidth);
        EXPECT_EQ(head->height, height);
        EXPECT_EQ(head->channel_count, 5);
    }
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
    std::string why;
    const auto read = picture_codec().open(path, why);
    ASSERT_TRUE(read) << why;
    std::vector<float> back(values.size());
    ASSERT_TRUE(read->read_rows(0, 1, 1, back.data()));
    EXPECT_EQ(back, nearest);
    const std::vector<float> nan{std::numeric_limits<float>::quiet_NaN()};
    const auto other = folder.write("b.exr", exr(spec_of(1, 1, {"Y"}, {SampleType::Half}), nan, {}));
    const auto of_nan = picture_codec().open(other, why);
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

TEST(ExrFile, AHeadThatIsCutOffIsNone)
{
    const TempFolder folder;
    const std::string whole = exr(spec_of(4, 4, {"R", "G"}, {SampleType::Float, SampleType::Half}), std::vector<float>(32),
                                  {});
    const std::size_t head = whole.find("screenWindowWidth");
    for (std::size_t size = 0; size < head; size += 7)
        EXPECT_FALSE(read_exr_head(folder.write("a.exr", whole.substr(0, size)))) << size;
    EXPECT_FALSE(read_exr_head(folder.path() / "none.exr"));
}

// Makes a Radiance file from its rows.
std::string radiance(int width, int height, const std::string& rows, const std::string& more = {})
{
    return "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n" + more + "\n-Y " + std::to_string(height) + " +X " +
           std::to_string(width) + "\n" + rows;
}

std::string noisy_row(int width, unsigned seed)
{
    std::string row;
    for (int i = 0; i < 4 * width; ++i) row += static_cast<char>((seed = seed * 1664525u + 1013904223u) >> 24);
    return row;
}

// Compresses a row: every second value as a run of one length, all others as they are.
std::string compressed_row(int width, unsigned seed)
{
    std::string row{2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
    for (int channel = 0; channel < 4; ++channel)
        for (int x = 0; x < width;) {
            seed = seed * 1664525u + 1013904223u;
            const int length = std::min(width - x, 1 + int(seed >> 26));
            const bool is_run = (seed >> 8 & 1) != 0;
            row += static_cast<char>(is_run ? 128 + length : length);
            for (int i = 0; i < (is_run ? 1 : length); ++i) row += static_cast<char>((seed >> 4) + unsigned(i));
            x += length;
        }
    return row;
}

TEST(RadianceFile, IsReadAsTheLibraryReadsIt)
{
    const TempFolder folder;
    std::string flat, compressed, narrow;
    for (unsigned y = 0; y < 5; ++y) {
        flat += noisy_row(20, y);
        compressed += compressed_row(300, y);
        narrow += noisy_row(7, y);
    }
    for (const std::string& bytes : {radiance(20, 5, flat), radiance(300, 5, compressed), radiance(7, 5, narrow),
                                     radiance(7, 5, narrow, "SOFTWARE=a test\n")}) {
        const auto path = folder.write("a.hdr", bytes);
        std::string why;
        const auto own = open_radiance(path), other = picture_codec().open(path, why);
        ASSERT_TRUE(own && other) << why;
        ASSERT_EQ(own->spec().width, other->spec().width);
        ASSERT_EQ(own->spec().height, other->spec().height);
        EXPECT_EQ(own->format(), other->format());
        std::vector<float> a(std::size_t(own->spec().width) * 5 * 3), b(a.size());
        ASSERT_TRUE(other->read_rows(0, 5, 3, b.data()));
        const std::size_t row = a.size() / 5;
        ASSERT_TRUE(own->read_rows(3, 5, 3, a.data() + 3 * row)) << own->error();
        ASSERT_TRUE(own->read_rows(0, 3, 3, a.data())) << own->error();
        // Some of the library's powers of two are off by rounding.
        for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-6f * b[i]) << i;
    }
}

TEST(RadianceFile, OtherHeadersAreLeftToTheLibrary)
{
    const TempFolder folder;
    const std::string rows = noisy_row(2, 1), head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";
    for (const std::string& bytes :
         {std::string(), std::string("#?RADIANCE"), head + "\n+Y 1 +X 2\n" + rows, head + "\n-Y 1 -X 2\n" + rows,
          head + "EXPOSURE=2\n\n-Y 1 +X 2\n" + rows, head + "\n-Y 1 +X 2 \n" + rows, head + "\n-Y 0 +X 2\n" + rows,
          head + "\n-Y 1 +X -2\n" + rows, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n" + rows,
          head + std::string(1 << 20, '#')})
        EXPECT_FALSE(open_radiance(folder.write("a.hdr", bytes))) << bytes.substr(0, 60);
    EXPECT_FALSE(open_radiance(folder.path() / "none.hdr"));
}

TEST(RadianceFile, RowsThatAreCutOffOrDamagedAreErrors)
{
    const TempFolder folder;
    std::vector<float> to(300 * 2 * 3);
    const std::string rows = compressed_row(300, 1) + compressed_row(300, 2);
    for (const std::size_t size : {std::size_t(0), std::size_t(3), std::size_t(50), rows.size() - 1}) {
        const auto read = open_radiance(folder.write("a.hdr", radiance(300, 2, rows.substr(0, size))));
        ASSERT_TRUE(read);
        EXPECT_FALSE(read->read_rows(0, 2, 3, to.data())) << size;
        EXPECT_NE(read->error(), "");
    }
    std::string too_long = rows;
    too_long[4] = char(255);  // a run that reaches past the end, once others have filled most of the row
    for (std::size_t i = 6; i < 12; ++i) too_long[i] = char(255);
    const auto read = open_radiance(folder.write("a.hdr", radiance(20, 2, std::string{2, 2, 0, 20} + too_long.substr(4))));
    ASSERT_TRUE(read);
    EXPECT_FALSE(read->read_rows(0, 2, 3, to.data()));
    const auto other_width = open_radiance(folder.write("a.hdr", radiance(301, 2, rows)));
    ASSERT_TRUE(other_width);
    EXPECT_FALSE(other_width->read_rows(0, 2, 3, to.data()));
}

}  // namespace
}  // namespace occam
