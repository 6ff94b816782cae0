// Tests of `occam compare` at the command line.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

using CompareCommand = CommandTest;

TEST_F(CompareCommand, ChecksItsLimits)
{
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.exr", "--size", "32x32", "--spp", "1"}).exit_code, kDone);
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "b.exr", "--size", "32x32", "--spp", "4"}).exit_code, kDone);
    EXPECT_EQ(run({"compare", "a.exr", "a.exr", "--max-error", "0"}).exit_code, kDone);
    EXPECT_EQ(run({"compare", "a.exr", "b.exr"}).exit_code, kDone);
    const Outcome o = run({"compare", "a.exr", "b.exr", "--max-error", "1e-9", "--heat", "heat.png", "--json"});
    EXPECT_EQ(o.exit_code, kDoesNotHold);
    EXPECT_NE(o.err.find("max error"), std::string::npos);
    EXPECT_NE(o.out.find("\"rmse\""), std::string::npos);
    EXPECT_TRUE(fs::exists(folder / "heat.png"));
}

TEST_F(CompareCommand, JudgesTheLayerAndTheAlphaOfThePicture)
{
    const auto write = [&](const char* name, float value, float alpha, std::vector<std::string> of_extra) {
        render::Image image(2, 2);
        image.add_layer("beauty", {"R", "G", "B", "A"}).pixels = {value, value, value, alpha, value, value, value, alpha,
                                                                  value, value, value, alpha, value, value, value, alpha};
        image.add_layer("foo", std::move(of_extra));
        image.write(folder / name);
    };
    write("a.exr", 0, 1, {"R", "G"});
    write("b.exr", 0, 0, {"R", "G"});
    write("c.exr", 0, 1, {"R"});
    write("d.exr", NAN, 1, {"R"});
    const Outcome clear = run({"compare", "a.exr", "b.exr", "--max-error", "0"});
    EXPECT_EQ(clear.exit_code, kDoesNotHold);
    EXPECT_NE(clear.out.find("beauty.A: mse 1, "), std::string::npos) << clear.out;
    EXPECT_NE(clear.err.find("(beauty.A)"), std::string::npos) << clear.err;
    EXPECT_EQ(run({"compare", "a.exr", "b.exr", "--max-error", "0", "--layer", "foo"}).exit_code, kDone);
    EXPECT_EQ(run({"compare", "a.exr", "b.exr", "--max-error", "0.5", "--layer", "beauty.A"}).exit_code, kDoesNotHold);
    // The alpha of a grey picture is no colour of it, either.
    for (const auto& [name, alpha] : {std::pair("grey0.exr", 0.0f), {"grey1.exr", 1.0f}}) {
        render::Image grey(2, 2);
        grey.add_layer("beauty", {"Y", "A"}).pixels = {0, alpha, 0, alpha, 0, alpha, 0, alpha};
        grey.write(folder / name);
    }
    const Outcome of_grey = run({"compare", "grey0.exr", "grey1.exr"});
    EXPECT_NE(of_grey.out.find("beauty: mse 0, "), std::string::npos) << of_grey.out;
    EXPECT_NE(of_grey.out.find("beauty.A: mse 1, "), std::string::npos) << of_grey.out;

    const Outcome other = run({"compare", "a.exr", "c.exr", "--max-error", "0"});
    EXPECT_EQ(other.exit_code, kDone) << other.err;
    EXPECT_NE(other.out.find("foo: cannot be compared"), std::string::npos) << other.out;
    EXPECT_EQ(run({"compare", "a.exr", "c.exr", "--layer", "foo", "--max-error", "0"}).exit_code, kBadInput);

    const Outcome none = run({"compare", "c.exr", "d.exr"});
    EXPECT_EQ(none.exit_code, kDone);
    EXPECT_NE(none.out.find("beauty: mse nan, rmse nan, rel-mse nan, psnr nan dB, max nan, p99.9 nan, 4 pixels cannot"),
              std::string::npos)
        << none.out;
}

}  // namespace
}  // namespace occam
