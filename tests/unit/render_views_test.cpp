// Tests of views that show one fact about each hit.
#include "render/views.h"

#include <gtest/gtest.h>
#include <occam/occam.h>

#include <array>
#include <set>

namespace occam::test {
namespace {

TEST(Views, FacesOfTwoCagesOfANodeHaveColoursOfTheirOwn)
{
    Scene scene;
    const auto square = [&](float x) {
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {{x, -1, 0}, {x + 1, -1, 0}, {x + 1, 1, 0}, {x, 1, 0}};
        cage.face_vertices = {0, 1, 2, 0, 2, 3};
        return scene.add(std::move(cage));
    };
    NodeDesc desc;
    desc.cages = {square(-1.2f), square(0.2f)};
    scene.add_node(scene.root(), desc);
    const Camera camera = Camera::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.6f);
    const Image image =
        Renderer({.threads = 1}).render(scene, camera, {.width = 48, .height = 36, .spp = 1, .view = View::Face});
    const std::vector<float>& pixels = image.layers().front().pixels;
    std::set<std::array<float, 3>> colors;
    for (std::size_t i = 0; i < pixels.size(); i += 4)
        if (pixels[i + 3] > 0) colors.insert({pixels[i], pixels[i + 1], pixels[i + 2]});
    EXPECT_EQ(colors.size(), 4u);
}

// The numbers are those that the help and docs/outputs.md give.
TEST(Views, CostsGoFromBlackOverRedAndYellowToWhite)
{
    const auto color = [](std::uint32_t nodes) {
        accel::RayCost cost{};
        cost.nodes = nodes;
        return render::cost_color(View::KdSteps, cost);
    };
    const auto expect_near = [](Vec3f a, Vec3f b) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 0.01f);
    };
    expect_near(color(0), {0, 0, 0});
    expect_near(color(9), {1, 0, 0});
    expect_near(color(101), {1, 1, 0});
    expect_near(color(1023), {1, 1, 1});
}

}  // namespace
}  // namespace occam::test
