// Tests of which images of an environment are sampled by their brightness.
#include "shade/environment.h"

#include <gtest/gtest.h>

#include "scenegraph/scene.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

// An environment of an image whose texels are what a function says of their column and row.
struct ImageSky {
    static constexpr int kWidth = 32, kHeight = 16;
    Scene scene;
    TextureStore textures{1 << 20};
    Environment environment;

    template <class ColorOf>
    explicit ImageSky(ColorOf&& color_of)
    {
        Texture texture;
        texture.width = kWidth;
        texture.height = kHeight;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) texture.pixels.push_back(Vec4f(color_of(x, y), 1));
        scene.environment.radiance = Vec3f(2);
        scene.environment.image = scene.add(texture);
        textures.prepare(scene);
        environment = Environment(scene.environment, textures);
    }
};

constexpr Vec3f kDirections[] = {{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {-0.6f, 0, 0.8f}, {0.48f, -0.6f, 0.64f}};

TEST(Environment, AnImageOfOneColorIsThatColorAndHasNoSamples)
{
    const ImageSky sky([](int, int) { return Vec3f(0.25f, 0.5f, 1); });
    EXPECT_FALSE(sky.environment.has_density());
    EXPECT_FALSE(sky.environment.is_black());
    for (const Vec3f d : kDirections) {
        EXPECT_EQ(sky.environment.radiance(d), Vec3f(0.5f, 1, 2));
        EXPECT_EQ(sky.environment.look_up(d).density, 0);
    }
}

TEST(Environment, ABlackImageIsAnEnvironmentWithoutLight)
{
    const ImageSky sky([](int, int) { return Vec3f(0); });
    EXPECT_FALSE(sky.environment.is_black()) << "it was asked for, and so no other sky takes its place";
    EXPECT_FALSE(sky.environment.has_density());
    for (const Vec3f d : kDirections) EXPECT_EQ(sky.environment.radiance(d), Vec3f(0));
}

TEST(Environment, AnEvenImageKeepsItsTexelsAndHasNoSamples)
{
    const ImageSky sky([](int, int y) { return y < ImageSky::kHeight / 2 ? Vec3f(1, 1, 1.5f) : Vec3f(0.5f, 0.5f, 0.25f); });
    EXPECT_FALSE(sky.environment.has_density());
    EXPECT_EQ(sky.environment.radiance({0, 1, 0}), Vec3f(2, 2, 3));
    EXPECT_EQ(sky.environment.radiance({0, -1, 0}), Vec3f(1, 1, 0.5f));
}

TEST(Environment, AnImageWithASmallBrightPatchIsSampled)
{
    const ImageSky sky([](int x, int y) { return Vec3f(x == 5 && y == 4 ? 500.0f : 1.0f); });
    EXPECT_TRUE(sky.environment.has_density());
    EXPECT_GT(sky.environment.look_up({0, 1, 0}).density, 0);
}

TEST(Environment, SeveralDirectionsAtOnceHaveTheBitsOfOneAtATime)
{
    const ImageSky sky(
        [](int x, int y) { return x == 20 && y == 5 ? Vec3f(50, 40, 30) : Vec3f(0.1f * float(x), 0.2f, 0.3f); });
    ASSERT_TRUE(sky.environment.has_density());
    const auto same = [](const Environment::Light& a, const Environment::Light& b) {
        return a.direction == b.direction && a.radiance == b.radiance && a.density == b.density;
    };
    test::Numbers numbers(9);
    for (std::size_t count = 1; count <= Environment::kAtOnce; ++count)
        for (int repeat = 0; repeat < 100; ++repeat) {
            Vec2f squares[Environment::kAtOnce];
            Vec3f directions[Environment::kAtOnce];
            Environment::Light drawn[Environment::kAtOnce], seen[Environment::kAtOnce];
            for (std::size_t k = 0; k < count; ++k) {
                squares[k] = numbers.square();
                const Vec2f square = numbers.square();
                directions[k] = glm::normalize(Vec3f(square.x - 0.5f, square.y - 0.5f, numbers.one() - 0.5f));
            }
            if (repeat < 5) directions[0] = kDirections[repeat];
            sky.environment.draw(std::span(squares, count), drawn);
            sky.environment.look_up(std::span(directions, count), seen);
            for (std::size_t k = 0; k < count; ++k) {
                EXPECT_TRUE(same(drawn[k], sky.environment.draw(squares[k])));
                EXPECT_TRUE(same(seen[k], sky.environment.look_up(directions[k])));
            }
        }
}

}  // namespace
}  // namespace occam::shade
