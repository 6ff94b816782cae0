// Tests of notes that a format of files keeps, and of those that it cannot keep.
#include <gtest/gtest.h>

#include "base/error.h"
#include "render/picture_formats.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class PictureNotes : public CommandTest {
protected:
    void SetUp() override
    {
        CommandTest::SetUp();
        fs::remove(folder / "triangle.obj");
        image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(std::size_t(9) * 7 * 3, 0.5f);
    }
    fs::path file_of(const render::PictureFormat& format) const
    {
        return folder / ("a" + std::string(format.extensions.substr(0, format.extensions.find(' '))));
    }
    /// Returns why a note is refused, or an empty string if it is written and read back as it was.
    std::string refusal(const fs::path& file, const std::string& note, render::Tonemap tonemap = render::Tonemap::Filmic)
    {
        try {
            image.write(file, {.exposure_ev = 0.0f, .tonemap = tonemap, .note = note});
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), Error::Kind::Output);
            EXPECT_TRUE(fs::is_empty(folder)) << file;
            return error.what();
        }
        EXPECT_TRUE(render::Image::read_head(file).note == note) << file << ", " << note.size() << " bytes";
        fs::remove(file);
        return {};
    }

    render::Image image{9, 7};
};

// libjpeg ends the process where a note does not fit into a segment.
TEST_F(PictureNotes, AreKeptWholeOrRefused)
{
    for (const render::PictureFormat& format : render::picture_formats())
        for (const int size : {2048, 2049, 60'000, 65'434, 65'435, 65'536, 65'537, 70'000, 3'000'000}) {
            const std::string why = refusal(file_of(format), std::string(std::size_t(size), 'x'));
            const std::string limit = "and " + std::string(format.name) + " allows ";
            EXPECT_TRUE(why.empty() || why.find(limit) != std::string::npos) << why;
        }
}

TEST_F(PictureNotes, AreKeptUpToTheLongestOfTheirFormat)
{
    for (const render::PictureFormat& format : render::picture_formats())
        for (const render::Tonemap tonemap : {render::Tonemap::Filmic, render::Tonemap::None})
            for (const char* unit : {"x", "&", "\xc3\xa9"}) {
                const std::size_t longest = format.longest_note;
                const bool takes_long = longest > 1'000'000;
                std::string note;
                while (!takes_long && note.size() < longest) note += unit;
                note.resize(longest, 'x');
                if (!takes_long) {
                    EXPECT_EQ(refusal(file_of(format), note, tonemap), "") << format.name;
                }
                const std::string why = refusal(file_of(format), note + 'x', tonemap);
                EXPECT_NE(why.find("allows " + std::to_string(longest)), std::string::npos) << why;
                if (takes_long) break;
            }
}

// A line of a note takes whole lines of the head of a Radiance file.
TEST_F(PictureNotes, OfRadianceFilesHaveFewLines)
{
    const fs::path file = folder / "a.hdr";
    EXPECT_EQ(refusal(file, std::string(31, '\n')), "") << "32 lines";
    EXPECT_NE(refusal(file, std::string(32, '\n')), "");
    EXPECT_EQ(refusal(file, std::string(65, 'x') + std::string(30, '\n')), "");
    EXPECT_NE(refusal(file, std::string(65, 'x') + std::string(31, '\n')), "");
}

TEST_F(PictureNotes, WithAZeroByteAreRefused)
{
    for (const render::PictureFormat& format : render::picture_formats()) {
        const std::string why = refusal(file_of(format), std::string("one\0two", 7));
        EXPECT_NE(why.find("its note has a zero byte"), std::string::npos) << format.name << ": " << why;
    }
}

}  // namespace
}  // namespace occam
