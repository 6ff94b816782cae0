// Which shared libraries the executable loads, and when.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class CommandLibraries : public CommandTest {
protected:
    // Runs the executable with the dynamic linker's report of what it initialises on standard error.
    std::string report(const std::vector<std::string>& arguments)
    {
        before_exec = [] { setenv("LD_DEBUG", "files", 1); };
        const Outcome o = run(arguments);
        EXPECT_EQ(o.exit_code, kDone);
        return o.err;
    }
    static long count(const std::string& text, const std::string& what)
    {
        long found = 0;
        for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
        return found;
    }
};

TEST_F(CommandLibraries, AreFewUntilAPictureNeedsMore)
{
    constexpr long kMost = 40;  // 13 and those of a sanitizer; the picture formats bring 250
    const auto rendering = [](const char* file) {
        return std::vector<std::string>{"render", "triangle.obj", "-o", file, "--size", "4x4", "--spp", "1"};
    };
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--version"},
                                                      {"render", "--help"},
                                                      {"info", "triangle.obj"},
                                                      rendering("a.png"),
                                                      rendering("a.exr")}) {
        const std::string loaded = report(arguments);
        EXPECT_GT(count(loaded, "calling init"), 5) << "the report of the dynamic linker is not as expected";
        EXPECT_LT(count(loaded, "calling init"), kMost) << arguments.front();
        EXPECT_EQ(loaded.find("OpenImageIO"), std::string::npos) << arguments.front();
    }
    EXPECT_NE(report(rendering("a.jpg")).find("OpenImageIO"), std::string::npos);
}

// A copy of the program without its module still does what needs no picture, and says at once what is missing otherwise.
TEST_F(CommandLibraries, AMissingModuleIsOneLineBeforeAnyWork)
{
    const fs::path built = fs::path(occam_executable()).parent_path(), copy = folder / "bin";
    fs::create_directory(copy);
    fs::copy_file(occam_executable(), copy / "occam");
    fs::copy_file(fs::canonical(built / "liboccam.so.0"), copy / "liboccam.so.0");
    const auto run_copy = [&](const std::vector<std::string>& arguments) {
        before_exec = [&] {
            setenv("LD_LIBRARY_PATH", copy.c_str(), 1);
            std::vector<char*> argv{const_cast<char*>("occam")};
            for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
            argv.push_back(nullptr);
            execv((copy / "occam").c_str(), argv.data());
        };
        return run(arguments);
    };
    EXPECT_EQ(run_copy({"info", "triangle.obj"}).exit_code, kDone);
    EXPECT_EQ(run_copy({"render", "triangle.obj", "-o", "a.png", "--size", "4x4", "--spp", "1"}).exit_code, kDone);
    const Outcome o = run_copy({"render", "triangle.obj", "-o", "a.jpg", "--size", "4x4", "--spp", "1"});
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_NE(o.err.find("liboccam_images.so"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find("it belongs beside liboccam.so"), std::string::npos) << o.err;
}

}  // namespace
}  // namespace occam
