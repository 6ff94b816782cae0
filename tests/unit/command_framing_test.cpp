// Tests of where the executable puts its camera if it is not given one.
#include <algorithm>

#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

// The part of a picture that a surface covers, in pixels.
struct Covered {
    int x0 = 1000, x1 = -1, y0 = 1000, y1 = -1;
    int width() const { return x1 - x0 + 1; }
    int height() const { return y1 - y0 + 1; }
};

Covered covered(const fs::path& file)
{
    const render::Image image = render::Image::read(file);
    const render::Layer& beauty = *image.find("beauty");
    Covered c;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (beauty.pixels[std::size_t(y * image.width + x) * beauty.channel_count() + 3] > 0) {
                c.x0 = std::min(c.x0, x), c.x1 = std::max(c.x1, x);
                c.y0 = std::min(c.y0, y), c.y1 = std::max(c.y1, y);
            }
    return c;
}

class Framing : public CommandTest {
protected:
    Covered seen(const std::string& scene, const std::vector<std::string>& more = {}) const
    {
        std::vector<std::string> words{"render", scene,   "-o",    "a.exr",        "--size", "100x50",       "--spp",
                                       "1",      "--exr", "float", "--background", "off",    "--integrator", "direct"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        return covered(folder / "a.exr");
    }
    void write_cube() const
    {
        std::ofstream(folder / "cube.obj") << "v 90 90 90\n"  // no face uses this vertex
                                              "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n"
                                              "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
                                              "f 5 4 3 2\nf 6 7 8 9\nf 2 3 7 6\nf 4 5 9 8\nf 3 4 8 7\nf 5 2 6 9\n";
    }
};

TEST_F(Framing, AnObjectFillsThePictureAndIsNotCutOff)
{
    write_cube();
    for (const char* subdivide : {"on", "off"})
        for (const char* side : {"three-quarter", "back", "top"}) {
            const Covered c = seen("cube.obj", {"--subdivide", subdivide, "--view-from", side});
            EXPECT_GE(c.height(), 43) << subdivide << ' ' << side;
            EXPECT_GT(c.y0, 0) << subdivide << ' ' << side;
            EXPECT_LT(c.y1, 49) << subdivide << ' ' << side;
        }
}

// The whole clip has one camera and one exposure: no frame is cut off, and it does not matter which process makes which
// frame.
TEST_F(Framing, AClipStaysInThePictureAndItsShardsAgree)
{
    const std::string fish = (fs::path(OCCAM_SOURCE_DIR) / "samples/scenes/fish.glb").string();
    const auto animate = [&](const std::string& pattern, const std::string& frames, const std::string& shard) {
        const Outcome o = run({"animate", fish, "-o", pattern, "--frames", frames, "--clip", "Swim", "--size", "60x40",
                               "--spp", "1", "--background", "off", "--shard", shard});
        EXPECT_EQ(o.exit_code, kDone) << o.err;
    };
    animate("a.##.exr", "0-18x6", "1/1");
    for (const char* name : {"a.00.exr", "a.06.exr", "a.12.exr", "a.18.exr"}) {
        const Covered c = covered(folder / name);
        EXPECT_TRUE(c.x0 > 0 && c.x1 < 59 && c.y0 > 0 && c.y1 < 39) << name;
        EXPECT_TRUE(c.height() > 30 || c.width() > 45) << name;
    }
    animate("b.##.png", "0-18x6", "1/1");
    animate("c.##.png", "0-18x6", "2/2");
    EXPECT_EQ(text_of(folder / "b.06.png"), text_of(folder / "c.06.png"));
    EXPECT_EQ(text_of(folder / "b.18.png"), text_of(folder / "c.18.png"));
}

TEST_F(Framing, UpAndTheAngleOfViewAreFollowed)
{
    // The file holds a mast along z, with a foot.
    std::ofstream(folder / "mast.obj") << "v 0 0 0\nv 0 0 9\nv 1 0 0\nv 0 1 0\nf 1 3 2\nf 1 4 2\n";
    const Covered lying = seen("mast.obj", {"--view-from", "side"});
    EXPECT_GT(lying.width(), 3 * lying.height());
    for (const char* up : {"z", "0,0,3"}) {
        const Covered upright = seen("mast.obj", {"--view-from", "side", "--up", up});
        EXPECT_GT(upright.height(), 3 * upright.width());
        EXPECT_GE(upright.height(), 43);
    }
    EXPECT_GE(seen("mast.obj", {"--up", "z", "--fov", "90"}).height(), 40);
    EXPECT_GE(seen("mast.obj", {"--up", "z", "--fov", "5"}).height(), 40);
}

TEST_F(Framing, BadSidesAndDirectionsAreRefused)
{
    for (const std::vector<std::string>& bad :
         std::vector<std::vector<std::string>>{{"--view-from", "inside"},
                                               {"--up", "w"},
                                               {"--up", "0,0,0"},
                                               {"--view-from", "front", "--look-at", "0,0,9,0,0,0"}}) {
        std::vector<std::string> words{"render", "triangle.obj", "-o", "a.png"};
        words.insert(words.end(), bad.begin(), bad.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << bad[1];
        EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    }
}

TEST_F(Framing, AnOrthographicCameraHasNoAngle)
{
    std::ofstream(folder / "flat.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"camera": 0, "translation": [0, 0, 5]}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0.1, "zfar": 9}}]})";
    const std::vector<std::string> words{"render", "flat.gltf", "-o", "a.exr", "--size", "8x4", "--spp", "1"};
    EXPECT_EQ(run(words).exit_code, kDone);
    std::vector<std::string> with_angle = words;
    with_angle.insert(with_angle.end(), {"--fov", "40"});
    const Outcome refused = run(with_angle);
    EXPECT_EQ(refused.exit_code, kBadInput);
    EXPECT_NE(refused.err.find("orthographic"), std::string::npos) << refused.err;
    // Another place has another camera.
    with_angle.insert(with_angle.end(), {"--look-at", "0,0,5,0,0,0"});
    EXPECT_EQ(run(with_angle).exit_code, kDone);
}

}  // namespace
}  // namespace occam
