// Tests of which channels of a layer are written as colours, in all formats alike.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "render/display.h"
#include "render/picture_formats.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;
using render::Image;

Image of_channels(const std::vector<std::string>& channels, const std::vector<float>& pixel)
{
    Image image(4, 3);
    std::vector<float>& pixels = image.add_layer("beauty", channels).pixels;
    pixels.clear();
    for (int i = 0; i < 4 * 3; ++i) pixels.insert(pixels.end(), pixel.begin(), pixel.end());
    return image;
}

class PictureColors : public CommandTest {
protected:
    /// Returns the pixel that the file of another extension holds, without a tone curve of its own.
    std::vector<float> written(const Image& image, const std::string& extension)
    {
        const fs::path file = folder / ("a" + extension);
        image.write(file, {.exposure_ev = 0.0f, .tonemap = render::Tonemap::Srgb});
        const Image read = Image::read(file);
        const render::Layer& layer = read.layers()[0];
        return {layer.pixels.begin(), layer.pixels.begin() + std::ptrdiff_t(layer.channel_count())};
    }
    void expect_colors(const Image& image, const std::vector<float>& expected)
    {
        for (const char* extension : {".png", ".jpg", ".tif", ".hdr"}) {
            const std::vector<float> found = written(image, extension);
            std::vector<float> pixel = expected;
            if (extension == std::string(".jpg") && pixel.size() == 4)  // what a screen shows is laid over black
                for (std::size_t c = 0; c < 3; ++c)
                    pixel[c] = render::linear_from_srgb(render::srgb_from_linear(pixel[c] / pixel[3]) * pixel[3]);
            const bool has_alpha = extension == std::string(".png") || extension == std::string(".tif");
            if (!has_alpha) pixel.resize(3);
            ASSERT_EQ(found.size(), pixel.size()) << extension;
            // A step of eight bits of sRGB is at most 0.009, and JPEG may be off by another one.
            for (std::size_t c = 0; c < pixel.size(); ++c) EXPECT_NEAR(found[c], pixel[c], 0.02f) << extension << ' ' << c;
        }
    }
};

// All grey pictures that are read are written.
TEST_F(PictureColors, OfGreyPicturesAreThreeOfTheSame)
{
    std::ofstream(folder / "g.pgm", std::ios::binary) << "P5\n4 3\n255\n" << std::string(12, char(200));
    const Image read = Image::read(folder / "g.pgm");
    ASSERT_EQ(read.layers()[0].channels, std::vector<std::string>{"Y"});
    const float grey = render::linear_from_srgb(200.0f / 255);
    expect_colors(read, {grey, grey, grey});
    expect_colors(of_channels({"I"}, {grey}), {grey, grey, grey});
    expect_colors(of_channels({"A", "Y"}, {0.5f, 0.25f}), {0.25f, 0.25f, 0.25f, 0.5f});
    expect_colors(of_channels({"Y", "Z"}, {grey, 7}), {grey, grey, grey});
    EXPECT_EQ(render::automatic_exposure(of_channels({"Y"}, {0.001f})),
              render::automatic_exposure(of_channels({"R", "G", "B"}, {0.001f, 0.001f, 0.001f})));
}

TEST_F(PictureColors, AreFoundByTheirNames)
{
    expect_colors(of_channels({"B", "G", "R"}, {0.1f, 0.2f, 0.4f}), {0.4f, 0.2f, 0.1f});
    expect_colors(of_channels({"A", "B", "G", "R"}, {0.5f, 0.1f, 0.2f, 0.4f}), {0.4f, 0.2f, 0.1f, 0.5f});
    expect_colors(of_channels({"R", "G", "B", "Z"}, {0.1f, 0.2f, 0.4f, 0.25f}), {0.1f, 0.2f, 0.4f});
    expect_colors(of_channels({"Z", "R", "G", "B", "A"}, {0.25f, 0.1f, 0.2f, 0.4f, 0.5f}), {0.1f, 0.2f, 0.4f, 0.5f});
    EXPECT_EQ(render::automatic_exposure(of_channels({"R", "G", "B", "Z"}, {0.001f, 0.001f, 0.001f, 0.25f})),
              render::automatic_exposure(of_channels({"R", "G", "B"}, {0.001f, 0.001f, 0.001f})))
        << "a depth is no coverage";
}

TEST_F(PictureColors, ThatALayerLacksAreNamed)
{
    struct Case {
        std::vector<std::string> channels;
        const char* missing;
    };
    for (const Case& c : {Case{{"R", "G"}, "lacks B:"},
                          {{"R", "G", "A"}, "lacks B:"},
                          {{"U", "V"}, "lacks R, G, B:"},
                          {{"X", "Y", "Z"}, "lacks R, G, B:"},
                          {{"Y", "RY", "BY"}, "lacks R, G, B:"},
                          {{"A"}, "lacks R, G, B:"},
                          {{}, "lacks R, G, B:"}})
        for (const render::PictureFormat& format : render::picture_formats()) {
            if (format.holds_layers) continue;
            const fs::path file = folder / ("a" + std::string(format.extensions.substr(0, format.extensions.find(' '))));
            try {
                of_channels(c.channels, std::vector<float>(c.channels.size(), 0.5f)).write(file);
                ADD_FAILURE() << file << " was written: " << c.missing;
            } catch (const Error& error) {
                EXPECT_EQ(error.kind(), Error::Kind::Output);
                EXPECT_NE(std::string(error.what()).find(c.missing), std::string::npos) << error.what();
            }
            EXPECT_FALSE(fs::exists(file));
        }
    EXPECT_EQ(render::automatic_exposure(of_channels({"U", "V"}, {1e-3f, 1e-3f})), 0);
}

}  // namespace
}  // namespace occam
