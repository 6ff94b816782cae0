// Tests of pixels that end before others, once the error around them is small.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <cstring>

#include "base/luminance.h"
#include "render/film.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

// A torus over a floor, lit by a square lamp: most of the picture is even, and the penumbra is not. Its sides are no
// multiples of a tile's.
struct AdaptiveScene {
    Scene scene;
    Camera camera = Camera::look_at({0, 4, 5}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    Settings settings{.width = 50, .height = 35, .spp = 16, .integrator = IntegratorKind::Direct, .aovs = {Aov::Variance}};

    AdaptiveScene()
    {
        Cage floor;
        floor.scheme = Scheme::Triangles;
        floor.positions = {{-6, -1, -6}, {6, -1, -6}, {6, -1, 6}, {-6, -1, 6}};
        floor.face_vertices = {0, 2, 1, 0, 3, 2};
        place(scene, scene.add(std::move(floor)), Vec3d(0));
        place(scene, scene.add(torus()), Vec3d(0));
        NodeDesc lamp;
        lamp.place.translation = {1, 4, 0};
        lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
        lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(1), Vec3f(8)}});
        scene.add_node(scene.root(), lamp);
        settings.sky = shade::Sky::Off;
    }

    Image render(int spp, float error = 0, Resources resources = {.threads = 2})
    {
        settings.spp = spp;
        settings.error = error;
        settings.min_spp = 4;
        Renderer renderer(resources);
        Image image = renderer.render(scene, camera, settings);
        samples = renderer.stats().image.samples;
        return image;
    }

    std::uint64_t samples = 0;  ///< of the last picture
};

// Holds, for each pixel, what a picture of `spp` samples a pixel says: colour and relative error.
struct Estimates {
    std::vector<Vec4f> colors;
    std::vector<double> errors;

    explicit Estimates(const Image& image)
    {
        const std::vector<float>&beauty = image.find("beauty")->pixels, &variance = image.find("variance")->pixels;
        for (std::size_t i = 0; i < variance.size(); ++i) {
            const Vec4f color(beauty[4 * i], beauty[4 * i + 1], beauty[4 * i + 2], beauty[4 * i + 3]);
            colors.push_back(color);
            errors.push_back(std::sqrt(double(variance[i])) /
                             std::max(luminance(Vec3d(Vec3f(color))), double(render::PixelSums::kDarkest)));
        }
    }
};

constexpr int kTile = 16;

double error_around(const std::vector<double>& errors, int width, int height, int x, int y)
{
    double sum = 0;
    int count = 0;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
            if (u / kTile != x / kTile || v / kTile != y / kTile) continue;
            const double error = errors[std::size_t(v * width + u)];
            sum += error * error;
            ++count;
        }
    return std::sqrt(sum / count);
}

// Pictures without early ends say at 4, 8 and 16 samples what each pixel's error is, and so which end there.
TEST(AdaptiveSampling, EachPixelEndsWhereTheErrorAroundItIsSmall)
{
    constexpr float kError = 0.03f;
    AdaptiveScene subject;
    const int width = subject.settings.width, height = subject.settings.height;
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    std::vector<bool> goes_on(pixels, true);
    std::vector<Vec4f> expected(pixels);
    std::vector<double> errors(pixels);
    std::uint64_t samples = 0;
    int ended[3] = {};
    for (int k = 0; k < 3; ++k) {
        const Estimates here(subject.render(4 << k));
        for (std::size_t i = 0; i < pixels; ++i)
            if (goes_on[i]) expected[i] = here.colors[i], errors[i] = here.errors[i], samples += k ? 2 << k : 4;
        for (std::size_t i = 0; i < pixels; ++i)
            if (goes_on[i] && error_around(errors, width, height, int(i) % width, int(i) / width) < double(kError)) {
                goes_on[i] = false;
                ++ended[k];
            }
    }
    for (const int count : ended) EXPECT_GT(count, 20) << "some pixels have to end at each number of samples";
    const Estimates found(subject.render(16, kError));
    EXPECT_EQ(subject.samples, samples);
    for (std::size_t i = 0; i < pixels; ++i)
        EXPECT_EQ(found.colors[i], expected[i]) << "pixel " << int(i) % width << ", " << int(i) / width;
}

// What is saved where the picture is even is of use where it is not.
TEST(AdaptiveSampling, FewerSamplesHaveASmallerErrorThanEvenlySpreadOnes)
{
    AdaptiveScene subject;
    const Estimates best(subject.render(is_long() ? 2048 : 512));
    const auto error_of = [&](const Estimates& picture) {
        double sum = 0;
        for (std::size_t i = 0; i < best.colors.size(); ++i) {
            const Vec3d difference = Vec3d(Vec3f(picture.colors[i])) - Vec3d(Vec3f(best.colors[i]));
            sum += glm::dot(difference, difference);
        }
        return std::sqrt(sum / double(best.colors.size()));
    };
    const double even = error_of(Estimates(subject.render(16)));
    const std::uint64_t samples = subject.samples;
    const double adaptive = error_of(Estimates(subject.render(64, 0.1f)));
    EXPECT_LT(subject.samples, samples);
    EXPECT_LT(adaptive, 0.8 * even);
}

TEST(AdaptiveSampling, HasTheSameBitsInRoundsAndWithinAnyBudget)
{
    AdaptiveScene subject;
    const Image whole = subject.render(64, 0.03f, {.threads = 1});
    subject.settings.progressive = true;
    const Image rounds = subject.render(64, 0.03f, {.threads = 3, .memory_bytes = std::size_t(24) << 20});
    for (std::size_t k = 0; k < whole.layers().size(); ++k) {
        const std::vector<float>&a = whole.layers()[k].pixels, &b = rounds.layers()[k].pixels;
        ASSERT_EQ(a.size(), b.size());
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << whole.layers()[k].name;
    }
}

}  // namespace
}  // namespace occam::test
