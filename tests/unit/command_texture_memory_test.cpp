// Tests of sequences whose images are halved to fit --texture-memory.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using HalvedImages = test::CommandTest;

// The frames that are there would be mixed with sharper ones.
TEST_F(HalvedImages, InASequenceAreThoseOfAllFrames)
{
    render::Image stripes(64, 64);
    std::vector<float>& pixels = stripes.add_layer("beauty", {"R", "G", "B"}).pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = float(i / 3 % 2);
    stripes.write(folder / "stripes.png");
    std::ofstream(folder / "a.obj") << "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl m\n"
                                       "f 1/1 2/2 3/3\n";
    std::ofstream(folder / "a.mtl") << "newmtl m\nmap_Kd stripes.png\n";
    const auto outcome = [&](const std::string& frames, const std::vector<std::string>& more) {
        std::vector<std::string> words{"animate", "a.obj", "-o",    "f.####.exr", "--frames",      frames,
                                       "--size",  "16x16", "--spp", "1",          "--environment", "none"};
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    };
    const std::vector<std::string> little{"--texture-memory", "4K"};
    EXPECT_EQ(outcome("0-1", little).exit_code, test::kDone);
    const test::Outcome mixed = outcome("0-2", {});
    EXPECT_EQ(mixed.exit_code, test::kBadInput);
    EXPECT_NE(mixed.err.find("f.0000.exr"), std::string::npos) << mixed.err;
    EXPECT_FALSE(test::fs::exists(folder / "f.0002.exr"));
    EXPECT_EQ(outcome("0-2", little).exit_code, test::kDone);
    EXPECT_EQ(outcome("3", {}).exit_code, test::kDone);
    EXPECT_EQ(outcome("3-4", {"--texture-memory", "1G"}).exit_code, test::kDone) << "nothing is halved";
}

}  // namespace
}  // namespace occam
