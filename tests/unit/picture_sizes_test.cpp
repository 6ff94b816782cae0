// Tests of pictures that are larger than a format of files allows.
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
    constexpr int kSomeLonger = 1'000'100;
    for (const render::PictureFormat& format : render::picture_formats()) {
        const fs::path file = folder / ("a" + std::string(format.extensions.substr(0, format.extensions.find(' '))));
        const int largest = std::min(format.largest_side, kSomeLonger);
        for (const bool is_row : {true, false}) {
            line(largest, is_row).write(file);
            const render::PictureHead head = render::Image::read_head(file);
            EXPECT_EQ(is_row ? head.width : head.height, largest) << file;
            fs::remove(file);
            if (largest == kSomeLonger) continue;
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
