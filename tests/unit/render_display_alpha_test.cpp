// Tests of when a picture that is shown has alpha.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "render/display.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

int channels_of(float alpha, float most)
{
    Image image(2, 1);
    image.add_layer("beauty", {"R", "G", "B", "A"}).pixels = {0.5f, 0.5f, 0.5f, 1, 0.5f, 0.5f, 0.5f, alpha};
    return render::display_image(image, {.exposure_ev = 0}, most).channels;
}

TEST(DisplayAlpha, IsThereIfItRoundsToLessThanTheMost)
{
    for (const float most : {255.0f, 65535.0f}) {
        EXPECT_EQ(channels_of(1, most), 3);
        EXPECT_EQ(channels_of(1 - 0.4f / most, most), 3);
        EXPECT_EQ(channels_of(1 - 0.6f / most, most), 4);
        EXPECT_EQ(channels_of(0, most), 4);
    }
}

// The coverages of veils and of the wall behind them add up to 1 except for rounding.
TEST(DisplayAlpha, IsNotThereBehindVeilsBeforeAWall)
{
    for (const float opacity : {0.005f, 0.02f, 0.05f}) {
        Scene scene;
        Material m;
        m.alpha_mode = AlphaMode::Blend;
        m.base_color.w = opacity;
        Cage veil = unit_square(), wall = veil;
        veil.materials = {scene.add(m)};
        const CageId veils = scene.add(std::move(veil));
        for (int i = 1; i <= 8; ++i) place(scene, veils, Vec3d(-4, -4, 0.1 * i), 8);
        place(scene, scene.add(std::move(wall)), Vec3d(-4, -4, 0), 8);
        const Camera camera = Camera::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.5f);
        const Image image = Renderer({.threads = 1}).render(scene, camera, {.width = 8, .height = 8, .spp = 4});
        EXPECT_EQ(render::display_image(image, {}).channels, 3) << opacity;
        EXPECT_EQ(render::display_image(image, {}, 65535).channels, 3) << opacity;
    }
}

}  // namespace
}  // namespace occam::test
