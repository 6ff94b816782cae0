// The limit of scattered light that follows from the format of the output.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;
using CommandClamp = CommandTest;

TEST_F(CommandClamp, FollowsFromTheFormatAndTheExposure)
{
    const auto clamp_of = [&](const std::string& output, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"render", "triangle.obj", "-o", output,    "--size",
                                       "16x9",   "--spp",        "1",  "--stats", "-"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        const std::size_t at = o.out.find("\"clamp\": ");
        return at == std::string::npos ? std::string("none") : o.out.substr(at + 9, o.out.find(',', at) - at - 9);
    };
    EXPECT_EQ(clamp_of("a.png"), "2.0") << "usual light is shown as it is";
    EXPECT_EQ(clamp_of("a.png", {"--clamp", "auto", "--exposure", "0"}), "2.0");
    EXPECT_EQ(clamp_of("a.jpg", {"--exposure", "3"}).substr(0, 4), "0.25");
    EXPECT_EQ(clamp_of("a.png", {"--clamp", "0"}), "0.0");
    EXPECT_EQ(clamp_of("a.png", {"--clamp", "7.5"}), "7.5");
    EXPECT_EQ(clamp_of("a.png", {"--integrator", "direct"}), "0.0");
    EXPECT_EQ(clamp_of("a.exr"), "0.0");
    EXPECT_EQ(clamp_of("a.exr", {"--clamp", "3"}), "3.0");
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--clamp", "-1"}).exit_code, kBadInput);
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--clamp", "some"}).exit_code, kBadInput);
}

}  // namespace
}  // namespace occam
