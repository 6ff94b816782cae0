// Tests of calls to the facade with values at the ends of their ranges, and from several threads at once.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <sstream>
#include <thread>
#include <vector>

#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

const Camera kBefore = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f);

// Holds a cube as a Catmull-Clark cage, which is nearly a ball of radius 0.8 of its half side.
struct Ball {
    Scene scene;

    Ball()
    {
        NodeDesc desc;
        desc.cages = {scene.add(test::creased_cube(0))};
        scene.add_node(scene.root(), desc);
    }
};

TEST(Api, AnEnvironmentOfAnotherSceneIsRefused)
{
    Ball ball;
    Scene other;
    Texture texture;
    texture.width = texture.height = 1;
    texture.pixels = {Vec4f(1)};
    ball.scene.environment.image = other.add(texture);
    Renderer renderer({.threads = 1});
    std::ostringstream out;
    EXPECT_THROW(renderer.render(ball.scene, kBefore, {.width = 4, .height = 4}), Error);
    EXPECT_THROW(renderer.replay(ball.scene, kBefore, {.width = 4, .height = 4}, {}, out), Error);
    ball.scene.environment.image = ball.scene.add(texture);
    EXPECT_NO_THROW(renderer.render(ball.scene, kBefore, {.width = 4, .height = 4}));
}

}  // namespace
}  // namespace occam
