// Tests of what the heads of EXR files say of a picture, by the definitions of OpenEXR's standard attributes.
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;
using PictureAttributes = CommandTest;

TEST_F(PictureAttributes, MatricesLeadToTheCameraAndToTheDisplayWindow)
{
    const std::vector<std::string> perspective{"--look-at", "3,2,10,3,2,0", "--fov", "90"};
    std::ofstream(folder / "flat.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"camera": 0, "translation": [3, 2, 10]}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 20, "ymag": 10, "znear": 0.1, "zfar": 100}}]})";
    for (const bool is_perspective : {true, false}) {
        std::vector<std::string> words{"render", is_perspective ? "triangle.obj" : "flat.gltf",
                                       "-o",     "a.exr",
                                       "--size", "80x40",
                                       "--spp",  "1",
                                       "--crop", "0.5,1,0,1"};
        if (is_perspective) words.insert(words.end(), perspective.begin(), perspective.end());
        ASSERT_EQ(run(words).exit_code, kDone);
        const Imf::InputFile file((folder / "a.exr").c_str());
        const Imath::M44f camera = Imf::worldToCamera(file.header()), ndc = Imf::worldToNDC(file.header());
        const auto expect = [&](Imath::V3f point, Imath::V3f in_camera, float x, float y) {
            Imath::V3f found;
            camera.multVecMatrix(point, found);
            EXPECT_TRUE(found.equalWithAbsError(in_camera, 1e-4f)) << found;
            ndc.multVecMatrix(point, found);
            EXPECT_NEAR(found.x, x, 1e-4f) << point;
            EXPECT_NEAR(found.y, y, 1e-4f) << point;
        };
        // Ten in front of the camera the picture is 40 by 20 wide.
        expect({3, 2, 0}, {0, 0, 10}, 0.5f, 0.5f);
        expect({-17, 12, 0}, {-20, 10, 10}, 0, 0);
        expect({23, -8, 0}, {20, -10, 10}, 1, 1);
        const float wider = is_perspective ? 0.5f : 1;
        expect({23, -8, -10}, {20, -10, 20}, 0.5f + 0.5f * wider, 0.5f + 0.5f * wider);
        EXPECT_NO_THROW(ndc.inverse(true)) << "applications go back from pixels";
    }
}

TEST_F(PictureAttributes, CommentsSayWhereAPictureWasStopped)
{
    const auto comments = [&](std::initializer_list<std::string> more) {
        std::vector<std::string> words{"render", "triangle.obj", "-o", "a.exr", "--size", "8x4", "--spp", "2"};
        words.insert(words.end(), more);
        EXPECT_EQ(run(words).exit_code, kDone);
        return Imf::comments(Imf::InputFile((folder / "a.exr").c_str()).header());
    };
    EXPECT_NE(comments({}).find(", 2 samples a pixel, seed 0"), std::string::npos);
    EXPECT_NE(comments({"--deadline", "1e-9"}).find(", stopped at 0 of 2 samples a pixel, seed 0"), std::string::npos);
}

}  // namespace
}  // namespace occam
