// Tests that samples end with a message: for a motion file that is damaged, and for lack of memory.
#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>

#include "samples/common/failure.h"
#include "samples/makehuman/walk.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

const std::string kJoints =
    "HIERARCHY ROOT Root { OFFSET 0 0 0 CHANNELS 6 JOINT Hips { OFFSET 0 0 1 CHANNELS 3 End Site { "
    "OFFSET 0 0 1 } } }";
const std::string kFrame = " 0 0 0 10 20 30 40 50 60";

/// Returns what the sample says of the file. The body has no bones, which is found after the file has been read.
std::string error_for(const std::string& file)
{
    const test::TempFolder folder;
    Scene scene;
    try {
        sample::add_walk(scene, {}, folder.write("walk.bvh", file));
    } catch (const Error& error) {
        return error.what();
    } catch (const std::out_of_range&) {
    }
    return {};
}

TEST(SampleMotion, IsReadFromAFileThatIsWhole)
{
    EXPECT_EQ(error_for(kJoints + " MOTION Frames: 2 Frame Time: 0.04" + kFrame + kFrame), "");
}

TEST(SampleMotion, IsRefusedFromADamagedFile)
{
    const std::string damaged[] = {"",
                                   "}",
                                   kJoints + " } MOTION Frames: 1 Frame Time: 0.04" + kFrame,
                                   kJoints + " MOTION Frames: 2 Frame Time: 0.04" + kFrame,
                                   kJoints + " MOTION Frames: 400000000000 Frame Time: 0.04" + kFrame,
                                   kJoints + " MOTION Frames: 18446744073709551615 Frame Time: 0.04" + kFrame,
                                   kJoints + " MOTION Frames: 0 Frame Time: 0.04",
                                   kJoints + " MOTION Frames: 1 Frame Time: 0" + kFrame,
                                   kJoints + " MOTION Frames: 1 Frame Time: -0.04" + kFrame};
    for (const std::string& file : damaged)
        EXPECT_NE(error_for(file).find("is not a motion file, or ends early"), std::string::npos) << file;
}

template <class Exception>
std::string said_of(const Exception& exception, int exit_code)
{
    testing::internal::CaptureStderr();
    try {
        throw exception;
    } catch (...) {
        EXPECT_EQ(sample::exit_code_of_failure("occam_x"), exit_code);
    }
    return testing::internal::GetCapturedStderr();
}

TEST(Samples, SayInALineWhyTheyEnd)
{
    EXPECT_EQ(said_of(Error("a.glb", "is wrong"), 2), "occam_x: a.glb: is wrong\n");
    EXPECT_EQ(said_of(Error("a.png", "cannot be written", {}, Error::Kind::Output), 3),
              "occam_x: a.png: cannot be written\n");
    EXPECT_EQ(said_of(std::bad_alloc(), 3), "occam_x: there is not enough memory\n");
    EXPECT_EQ(said_of(std::runtime_error("something else"), 3), "occam_x: something else\n");
}

}  // namespace
}  // namespace occam
