// Tests of which images of an environment are sampled by their brightness.
#include "shade/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scenegraph/scene.h"
#include "tests/support/campaign.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

// An environment of an image whose texels are what a function says of their column and row.
struct ImageSky {
    static constexpr int kWidth = 32, kHeight = 16;
    Scene scene;
    TextureStore textures{1 << 24};
    Environment environment;

    template <class ColorOf>
    explicit ImageSky(ColorOf&& color_of, int width = kWidth, int height = kHeight)
    {
        Texture texture;
        texture.width = width;
        texture.height = height;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) texture.pixels.push_back(Vec4f(color_of(x, y), 1));
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

// The means of the cells of the table are those of an image of one colour.
TEST(Environment, AFinePatternIsSeen)
{
    const ImageSky sky([](int x, int y) { return Vec3f(float((x + y) % 2)); }, 1024, 512);
    EXPECT_FALSE(sky.environment.has_density());
    float darkest = 2, brightest = 0;
    for (int k = 0; k < 1000; ++k) {
        const float around = 2.4f * float(k), up = 0.001f * float(k) - 0.5f;
        const float radiance = sky.environment.radiance(glm::normalize(Vec3f(std::cos(around), up, std::sin(around)))).x;
        darkest = std::min(darkest, radiance);
        brightest = std::max(brightest, radiance);
    }
    EXPECT_LT(darkest, 0.4f);
    EXPECT_GT(brightest, 1.6f);
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

// Scattered directions would find a lamp of one texel as seldom as it is small, and count it as often as it is bright,
// though it adds too little light to make its cell uneven. The same light is even where it fills the cell.
TEST(Environment, LampsThatAreSmallerThanACellAreSampled)
{
    constexpr int kWidth = 2048, kHeight = 512, kAcross = kWidth / 512, kDown = kHeight / 256;
    const auto has_density = [](float lamp, int width, int height) {
        const ImageSky sky(
            [&](int x, int y) {
                const int across = x % (kWidth / 8) - 32 * kAcross, down = y - kHeight / 2;
                const bool is_lamp = across >= 0 && across < width && down >= 0 && down < height;
                return Vec3f(is_lamp ? 1 + lamp : 1.0f);
            },
            kWidth, kHeight);
        return sky.environment.has_density();
    };
    constexpr float kLight = 450;
    EXPECT_TRUE(has_density(kLight, 1, 1));
    EXPECT_FALSE(has_density(kLight / (kAcross * kDown), kAcross, kDown));
}

// The texel at the corner of a cell shines into three others. A sample counts its radiance over its density, and none counts
// for many times the light of all.
TEST(Environment, TheLightOfATexelAtTheBorderOfACellIsFound)
{
    for (const int width : {512, 1024, 2048}) {
        if (width == 2048 && !test::is_long()) continue;
        const int height = width / 2, bright_x = width / 512 * 175, bright_y = width / 512 * 50;
        Texture texture;
        texture.width = width;
        texture.height = height;
        texture.pixels.assign(std::size_t(width) * std::size_t(height), Vec4f(0, 0, 0, 1));
        texture.pixels[std::size_t(bright_y * width + bright_x)] = Vec4f(1000, 1000, 1000, 1);
        Scene scene;
        scene.environment.radiance = Vec3f(1);
        scene.environment.image = scene.add(texture);
        TextureStore textures(std::size_t(1) << 26);
        textures.prepare(scene);
        const Environment environment(scene.environment, textures);
        ASSERT_TRUE(environment.has_density());
        constexpr double kPi = 3.14159265358979;
        constexpr int kSteps = 16;  // in a texel
        double light = 0, second = 0, most = 0;
        for (int j = -kSteps; j < 2 * kSteps; ++j)
            for (int i = -kSteps; i < 2 * kSteps; ++i) {
                const double u = (bright_x + (i + 0.5) / kSteps) / width, v = (bright_y + (j + 0.5) / kSteps) / height;
                const double around = (u - 0.5) * 2 * kPi, down = v * kPi, ring = std::sin(down);
                const Vec3f direction(Vec3d(ring * std::sin(around), std::cos(down), -ring * std::cos(around)));
                const Environment::Light seen = environment.look_up(direction);
                const double counts = double(seen.radiance.x) / double(seen.density);
                const double solid_angle = 2 * kPi * kPi * ring / (width * height * kSteps * kSteps);
                light += double(seen.radiance.x) * solid_angle;
                second += double(seen.radiance.x) * counts * solid_angle;
                most = std::max(most, counts);
            }
        EXPECT_NEAR(light, 1000 * 2 * kPi * kPi * std::sin(kPi * (bright_y + 0.5) / height) / (width * height),
                    1e-2 * light);
        // Samples are spread evenly within a cell, of whose texels one shines.
        const double texels = double(width / 512) * double(width / 512);
        EXPECT_LT(most, 64 * texels * light) << width;
        EXPECT_LT(second, 4 * texels * light * light) << width;
    }
}

TEST(Environment, ATableIsKeptForItsImageAlone)
{
    const auto patch = [](int column) {
        return ImageSky([=](int x, int y) { return Vec3f(x == column && y == 5 ? 100 : 0.1f); });
    };
    const ImageSky first = patch(3), second = patch(20);
    const auto light = [](const Environment& of) { return of.draw({0.3f, 0.6f}); };
    Environment::Kept kept;
    for (const ImageSky* sky : {&first, &second, &first}) {
        occam::Environment description = sky->scene.environment;
        const auto last = kept;
        const Environment made(description, sky->textures, &kept);
        EXPECT_NE(kept, last);
        EXPECT_EQ(light(made).density, light(sky->environment).density);
        EXPECT_EQ(light(made).direction, light(sky->environment).direction);
        const auto table = kept;
        description.radiance = Vec3f(3);
        description.rotation = 1;
        const Environment turned(description, sky->textures, &kept), fresh(description, sky->textures);
        EXPECT_EQ(kept, table) << "neither strength nor rotation count";
        EXPECT_EQ(light(turned).radiance, light(fresh).radiance);
        EXPECT_EQ(light(turned).direction, light(fresh).direction);
    }
}

// The handle stays, and so do the sizes of the image and of its texels.
TEST(Environment, ATableIsMadeAnewForTexelsThatWereReplaced)
{
    const auto patch = [](int column) {
        return ImageSky([=](int x, int y) { return Vec3f(x == column && y == 5 ? 100 : 0.1f); });
    };
    ImageSky sky = patch(3);
    const ImageSky other = patch(20);
    Environment::Kept kept;
    const Environment first(sky.scene.environment, sky.textures, &kept);
    sky.scene.replace(sky.scene.environment.image, other.scene.texture(other.scene.environment.image));
    sky.textures.prepare(sky.scene);
    const Environment second(sky.scene.environment, sky.textures, &kept);
    EXPECT_EQ(second.draw({0.3f, 0.6f}).direction, other.environment.draw({0.3f, 0.6f}).direction);
    EXPECT_NE(second.draw({0.3f, 0.6f}).direction, sky.environment.draw({0.3f, 0.6f}).direction);
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
