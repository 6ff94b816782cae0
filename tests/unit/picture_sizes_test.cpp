// Tests of pictures that are larger than a format of files allows.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfRgbaFile.h>
#include <ImfStringAttribute.h>

#include <cstring>

#include "base/error.h"
#include "render/picture_formats.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class PictureSizes : public CommandTest {};

// Returns a picture of one row, or of one column.
render::Image line(int length, bool is_row)
{
    render::Image image(is_row ? length : 1, is_row ? 1 : length);
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(std::size_t(length) * 3, 0.5f);
    return image;
}

TEST_F(PictureSizes, AreWrittenUpToTheLargestOfTheirFormatAndRefusedBeyond)
{
    constexpr int kSomeLonger = 70'000;
    for (const render::PictureFormat& format : render::picture_formats()) {
        const fs::path file = folder / ("a" + std::string(format.extensions.substr(0, format.extensions.find(' '))));
        const bool has_limit = format.largest_side < std::numeric_limits<int>::max();
        const int largest = has_limit ? format.largest_side : kSomeLonger;
        for (const bool is_row : {true, false}) {
            line(largest, is_row).write(file);
            const render::PictureHead head = render::Image::read_head(file);
            EXPECT_EQ(is_row ? head.width : head.height, largest) << file;
            fs::remove(file);
            if (!has_limit) continue;
            try {
                line(largest + 1, is_row).write(file);
                ADD_FAILURE() << file << " was written";
            } catch (const Error& error) {
                EXPECT_EQ(error.kind(), Error::Kind::Output);
                EXPECT_NE(std::string(error.what()).find("allows " + std::to_string(largest)), std::string::npos)
                    << error.what();
            }
        }
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1) << "nothing but the scene is left";
}

// Writes black halves, of which the library holds a few rows at a time.
void write_black(const fs::path& file, int width, int height, int channels)
{
    Imf::Header header(width, height);
    header.compression() = Imf::RLE_COMPRESSION;
    header.insert("occam:note", Imf::StringAttribute("a note"));
    Imf::FrameBuffer buffer;
    std::vector<half> row(std::size_t(width), half(0));
    for (int i = 0; i < channels; ++i) {
        const std::string name = "c" + std::to_string(i);
        header.channels().insert(name, Imf::Channel(Imf::HALF));
        buffer.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(row.data()), sizeof(half), 0));
    }
    Imf::OutputFile output(file.c_str(), header, 0);
    output.setFrameBuffer(buffer);
    output.writePixels(height);
}

// A sequence that goes on reads the heads of its frames, however large they are.
TEST_F(PictureSizes, DoNotMatterWhereOnlyTheHeadIsRead)
{
    const fs::path file = folder / "a.exr";
    write_black(file, 4096, 2100, 64);
    const render::PictureHead head = render::Image::read_head(file);
    EXPECT_EQ(head.height, 2100);
    EXPECT_EQ(head.note, "a note");
}

// The first channel by name is BY, which has a value for every second pixel of every second row.
TEST_F(PictureSizes, AreReadFromFilesOfSubsampledChannels)
{
    const fs::path file = folder / "a.exr";
    for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION}) {
        const std::vector<Imf::Rgba> pixels(64 * 48, Imf::Rgba(0.5f, 0.2f, 0.1f, 1));
        {
            Imf::RgbaOutputFile output(file.c_str(), 64, 48, Imf::WRITE_YC, 1, {0, 0}, 1, Imf::INCREASING_Y, compression, 0);
            output.setFrameBuffer(pixels.data(), 1, 64);
            output.writePixels(48);
        }
        const render::PictureHead head = render::Image::read_head(file);
        EXPECT_EQ(head.width, 64);
        EXPECT_EQ(head.height, 48);
        fs::resize_file(file, fs::file_size(file) - 1);
        EXPECT_THROW(render::Image::read_head(file), Error) << "it is cut off now";
    }
}

TEST_F(PictureSizes, OfAHeadThatLiesAreRefused)
{
    const fs::path file = folder / "a.exr";
    write_black(file, 8, 8, 1);
    const std::string whole = text_of(file);
    const std::size_t at = whole.find("box2i", whole.find("dataWindow")) + 6 + 4;  // its name and size come before it
    for (const auto& [right, bottom] : {std::pair(1 << 28, 7), std::pair(1 << 28, 1 << 29), std::pair(7, 1 << 30)}) {
        std::string lies = whole;
        std::memcpy(&lies[at + 8], &right, 4), std::memcpy(&lies[at + 12], &bottom, 4);
        std::ofstream(file, std::ios::binary) << lies;
        EXPECT_THROW(render::Image::read_head(file), Error) << right << ' ' << bottom;
    }
}

// Rendering would take far longer than the test may.
TEST_F(PictureSizes, AreRefusedBeforeThePictureIsMade)
{
    for (const char* command : {"render", "animate"}) {
        std::vector<std::string> words{command, "triangle.obj", "-o", "a.#.jpg", "--size", "65536x4096", "--spp", "65536"};
        if (command == std::string("animate")) words.insert(words.end(), {"--frames", "0", "--exposure", "0"});
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kOutput) << command;
        EXPECT_NE(o.err.find(".jpg: cannot be written: it has 65536 x 4096 pixels, and JPEG allows 65500 a side\n"),
                  std::string::npos)
            << o.err;
    }
    const Outcome cropped = run(
        {"render", "triangle.obj", "-o", "a.jpg", "--size", "65536x1", "--spp", "1", "--crop", "0,0.5,0,1"});
    EXPECT_EQ(cropped.exit_code, kDone) << cropped.err;
}

}  // namespace
}  // namespace occam
