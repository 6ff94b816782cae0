// Tests of sequences whose images are halved to fit --texture-memory.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

class HalvedImages : public test::CommandTest {
protected:
    void write_stripes(const std::string& name, int width, int height) const
    {
        render::Image stripes(width, height);
        std::vector<float>& pixels = stripes.add_layer("beauty", {"R", "G", "B"}).pixels;
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = float(i / 3 % 2);
        stripes.write(folder / name);
    }
    /// Writes a triangle, a.obj, whose image is 64 by 64.
    void write_triangle() const
    {
        write_stripes("stripes.png", 64, 64);
        std::ofstream(folder / "a.obj") << "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl m\n"
                                           "f 1/1 2/2 3/3\n";
        std::ofstream(folder / "a.mtl") << "newmtl m\nmap_Kd stripes.png\n";
    }
    test::Outcome outcome(const std::string& scene, const std::string& environment, const std::string& frames,
                          const std::vector<std::string>& more) const
    {
        std::vector<std::string> words{"animate", scene,   "-o",    "f.####.exr", "--frames",      frames,
                                       "--size",  "16x16", "--spp", "1",          "--environment", environment};
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    }
};

const std::vector<std::string> kLittle{"--texture-memory", "4K"}, kMuch{"--texture-memory", "1G"};

// The frames that are there would be mixed with sharper ones.
TEST_F(HalvedImages, InASequenceAreThoseOfAllFrames)
{
    write_triangle();
    EXPECT_EQ(outcome("a.obj", "none", "0-1", kLittle).exit_code, test::kDone);
    const test::Outcome mixed = outcome("a.obj", "none", "0-2", {});
    EXPECT_EQ(mixed.exit_code, test::kBadInput);
    EXPECT_NE(mixed.err.find("f.0000.exr"), std::string::npos) << mixed.err;
    EXPECT_FALSE(test::fs::exists(folder / "f.0002.exr"));
    EXPECT_EQ(outcome("a.obj", "none", "0-2", kLittle).exit_code, test::kDone);
    EXPECT_EQ(outcome("a.obj", "none", "3", {}).exit_code, test::kDone);
    EXPECT_EQ(outcome("a.obj", "none", "3-4", kMuch).exit_code, test::kDone) << "nothing is halved";
}

TEST_F(HalvedImages, OfTheEnvironmentAreThoseOfAllFrames)
{
    write_stripes("sky.hdr", 64, 32);
    EXPECT_EQ(outcome("triangle.obj", "sky.hdr", "0", kLittle).exit_code, test::kDone);
    const test::Outcome mixed = outcome("triangle.obj", "sky.hdr", "0-1", kMuch);
    EXPECT_EQ(mixed.exit_code, test::kBadInput);
    EXPECT_NE(mixed.err.find("f.0000.exr"), std::string::npos) << mixed.err;
    EXPECT_FALSE(test::fs::exists(folder / "f.0001.exr"));
    EXPECT_EQ(outcome("triangle.obj", "sky.hdr", "0-1", kLittle).exit_code, test::kDone);
}

// With 60K the triangle's image is halved only where that of the environment takes a part of them.
TEST_F(HalvedImages, AreHalvedBesideTheEnvironmentThatIsRendered)
{
    write_triangle();
    write_stripes("sky.hdr", 64, 32);
    const std::vector<std::string> some{"--texture-memory", "60K"};
    EXPECT_EQ(outcome("a.obj", "sky.hdr", "0", kMuch).exit_code, test::kDone);
    EXPECT_EQ(outcome("a.obj", "sky.hdr", "0", some).exit_code, test::kBadInput);
    EXPECT_EQ(outcome("a.obj", "none", "1", kMuch).exit_code, test::kDone);
    EXPECT_EQ(outcome("a.obj", "none", "1", some).exit_code, test::kDone) << "nothing is halved";
}

}  // namespace
}  // namespace occam
