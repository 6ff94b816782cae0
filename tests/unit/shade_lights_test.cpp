#include "shade/lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <limits>

#include "render/sampler.h"
#include "shade/direct.h"
#include "shade/frame_of.h"
#include "tests/support/statistics.h"

namespace occam::shade {
namespace {

constexpr double kPiD = 3.14159265358979;

// Returns the irradiance on a plane with this normal, from n x n stratified samples. For a smooth function the error is
// about its change over a cell divided by n, which is below 1e-3 here for n = 128.
double irradiance(const WorldLight& light, Vec3d point, Vec3f normal, int n = 128)
{
    const render::Sampler sampler(5, 1, true);
    const auto count = static_cast<std::uint32_t>(n * n);
    double sum = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const LightSample s = light.sample(point, {sampler.square(0, 0, i, render::Dimension::pixel()), 0.5f});
        sum += double(s.radiance.x) * double(std::max(0.0f, glm::dot(normal, s.direction)));
    }
    return sum / (n * n);
}

Light area(AreaLight::Shape shape, Vec2f size, float radiance, bool two_sided = false)
{
    return {"", AreaLight{shape, size, Vec3f(radiance), two_sided}};
}

// Returns the matrix of a node at (0, 0, z) that shines along the world's -z.
Mat4d above(double z) { return glm::translate(Mat4d(1), Vec3d(0, 0, z)); }

// Returns the form factor of a parallel rectangle with one corner above the point (Howell's catalogue, configuration B-4).
double corner_form_factor(double a, double b, double c)
{
    const double x = a / c, y = b / c;
    return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
            y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
           (2 * kPiD);
}

TEST(Lights, ASquareOverAPlaneGivesItsFormFactor)
{
    for (double height : {0.5, 1.0, 3.0}) {
        const WorldLight light = WorldLight::place(area(AreaLight::Shape::Rectangle, {2, 2}, 3), above(height));
        const double expected = 3 * kPiD * 4 * corner_form_factor(1, 1, height);
        EXPECT_NEAR(irradiance(light, Vec3d(0), {0, 0, 1}), expected, 2e-3 * expected) << height;
    }
}

// Of samples that are spread evenly over such lights, one in a thousand to one in 10^7 is near the point.
TEST(Lights, LongOnesGiveTheirFormFactor)
{
    for (const auto& [x, y] : {std::pair(1e4, 1e-4), {1e-4, 1e4}, {2e3, 1.0}, {1e7, 1e-2}, {300.0, 2.0}})
        for (const double height : {0.3, 1.0, 10.0}) {
            const WorldLight light = WorldLight::place(area(AreaLight::Shape::Rectangle, {float(x), float(y)}, 3),
                                                       above(height));
            const double expected = 3 * kPiD * 4 * corner_form_factor(x / 2, y / 2, height);
            EXPECT_NEAR(irradiance(light, Vec3d(0), {0, 0, 1}), expected, 0.01 * expected) << x << " x " << y;
            // A quarter of it, from below its corner.
            const Vec3d corner(-x / 2, -y / 2, 0);
            EXPECT_NEAR(irradiance(light, corner, {0, 0, 1}), 3 * kPiD * corner_form_factor(x, y, height), 0.01 * expected)
                << x << " x " << y;
        }
}

// A scattered ray that meets a light weighs it by the density with which the light's own samples are drawn.
TEST(Lights, FlatOnesKnowTheDensityOfTheirSamples)
{
    const render::Sampler sampler(5, 1, true);
    for (const auto shape : {AreaLight::Shape::Rectangle, AreaLight::Shape::Disc})
        for (const auto& [x, y] : {std::pair(1e3f, 1.0f), {1.0f, 1e3f}, {1.0f, 2.0f}, {3e7f, 3e7f}, {1e15f, 1e15f}}) {
            const WorldLight light = WorldLight::place(area(shape, {x, y}, 3), above(1));
            const Vec3d point(0.3, -0.2, 0);
            for (std::uint32_t i = 0; i < 100; ++i) {
                const LightSample s = light.sample(point, {sampler.square(0, 0, i, render::Dimension::pixel()), 0.5f});
                if (!(s.density > 0) || !(s.direction.z > 1e-3f)) continue;  // grazing directions round off the light
                const LightCrossing c = light.crossing(point, s.direction);
                if (c.density == 0) continue;  // rounded past the rim
                EXPECT_NEAR(c.density, s.density, 0.01f * s.density) << x << " x " << y;
                EXPECT_NEAR(s.radiance.x * s.density, 3, 1e-3f);
            }
            const LightCrossing up = light.crossing(Vec3d(0), {0, 0, 1});
            EXPECT_FLOAT_EQ(up.distance, 1 - 3 * LightGap::kUlps) << x << " x " << y;
            EXPECT_GT(up.density, 0) << x << " x " << y;
        }
}

TEST(Lights, ScaleOfTheNodeScalesTheArea)
{
    const WorldLight light = WorldLight::place(area(AreaLight::Shape::Rectangle, {1, 1}, 3),
                                               glm::scale(above(2), Vec3d(2, 2, 2)));
    const double expected = 3 * kPiD * 4 * corner_form_factor(1, 1, 2);
    EXPECT_NEAR(irradiance(light, Vec3d(0), {0, 0, 1}), expected, 2e-3 * expected);
}

// On the axis of a disc of radius r, E = pi L r^2 / (r^2 + h^2).
TEST(Lights, ADiscOverAPlaneGivesItsFormFactor)
{
    const WorldLight light = WorldLight::place(area(AreaLight::Shape::Disc, {2, 2}, 3), above(1.5));
    const double expected = 3 * kPiD / (1 + 1.5 * 1.5);
    EXPECT_NEAR(irradiance(light, Vec3d(0), {0, 0, 1}), expected, 2e-3 * expected);
}

// For a sphere wholly above the horizon, E = pi L (r / d)^2 cos.
TEST(Lights, ASphereGivesItsFormFactorNearAndFar)
{
    for (double distance : {1.01, 2.0, 1e4}) {
        const WorldLight light = WorldLight::place(area(AreaLight::Shape::Sphere, {2, 2}, 3), above(distance));
        const double expected = 3 * kPiD / (distance * distance);
        EXPECT_NEAR(irradiance(light, Vec3d(0), {0, 0, 1}), expected, 3e-3 * expected) << distance;
    }
    const WorldLight light = WorldLight::place(area(AreaLight::Shape::Sphere, {2, 2}, 3), above(0.5));
    EXPECT_EQ(light.sample(Vec3d(0), {}).radiance, Vec3f(0)) << "it shines outward: nothing inside";
}

TEST(Lights, ASamplesDistanceEndsOnTheSphere)
{
    const WorldLight light = WorldLight::place(area(AreaLight::Shape::Sphere, {2, 2}, 1), above(3));
    const render::Sampler sampler(5, 1, true);
    for (std::uint32_t i = 0; i < 64; ++i) {
        const LightSample s = light.sample({0.5, 0, 0}, {sampler.square(0, 0, i, render::Dimension::pixel()), 0.5f});
        const Vec3d p = Vec3d(0.5, 0, 0) + Vec3d(s.direction) * double(s.distance);
        EXPECT_NEAR(glm::length(p - Vec3d(0, 0, 3)), 1, 1e-5);
    }
}

TEST(Lights, FlatLightsShineToTheirFrontAlone)
{
    const Vec3d behind(0, 0, 3);
    const WorldLight one = WorldLight::place(area(AreaLight::Shape::Rectangle, {1, 1}, 1), above(1));
    const WorldLight two = WorldLight::place(area(AreaLight::Shape::Rectangle, {1, 1}, 1, true), above(1));
    EXPECT_EQ(one.sample(behind, {}).radiance, Vec3f(0));
    EXPECT_GT(two.sample(behind, {}).radiance.x, 0);
    const WorldLight mirrored = WorldLight::place(area(AreaLight::Shape::Rectangle, {1, 1}, 1),
                                                  glm::scale(above(1), Vec3d(-1, 1, 1)));
    EXPECT_GT(mirrored.sample(Vec3d(0), {}).radiance.x, 0) << "a mirrored node still shines along its -z";
}

TEST(Lights, APointLightFallsWithTheSquareOfDistance)
{
    const WorldLight light = WorldLight::place({"", PointLight{Vec3f(8)}}, above(2));
    EXPECT_FLOAT_EQ(light.sample(Vec3d(0), {}).radiance.x, 2);
    EXPECT_FLOAT_EQ(light.sample(Vec3d(0), {}).distance, 2 - 32 * LightGap::kUlps);
    EXPECT_TRUE(std::isfinite(light.sample({0, 0, 2}, {}).radiance.x)) << "in the light itself";
}

// By KHR_lights_punctual the light falls off as clamp(1 - (d / range)^4, 0, 1) / d^2.
TEST(Lights, APointLightEndsAtItsRange)
{
    PointLight point{Vec3f(1)};
    point.range = 4;
    const WorldLight light = WorldLight::place({"", point}, above(0));
    EXPECT_FLOAT_EQ(light.sample({2, 0, 0}, {}).radiance.x, (1 - 1.0f / 16) / 4);
    EXPECT_EQ(light.sample({4, 0, 0}, {}).radiance.x, 0);
    EXPECT_EQ(light.sample({5, 0, 0}, {}).radiance.x, 0);
}

TEST(Lights, ASpotIsFullInsideAndDarkOutside)
{
    PointLight spot{Vec3f(1)};
    spot.inner_angle = 0.3f;
    spot.outer_angle = 0.5f;
    const WorldLight light = WorldLight::place({"", spot}, above(1));
    const auto at = [&](double angle) {
        return light.sample({std::tan(angle), 0, 0}, {}).radiance.x * float(1 + std::pow(std::tan(angle), 2));
    };
    EXPECT_NEAR(at(0), 1, 1e-5);
    EXPECT_NEAR(at(0.29), 1, 1e-5);
    for (const double angle : {0.32, 0.4, 0.48}) {  // by KHR_lights_punctual the square of what is linear in the cosine
        const double cone = (std::cos(angle) - std::cos(0.5)) / (std::cos(0.3) - std::cos(0.5));
        EXPECT_NEAR(double(at(angle)), cone * cone, 1e-4) << angle;
    }
    EXPECT_EQ(at(0.51), 0);
}

TEST(Lights, ASunIsParallelAndInfinitelyFar)
{
    const WorldLight light = WorldLight::place({"", SunLight{Vec3f(5)}}, above(100));
    const LightSample s = light.sample({7, 8, 9}, {});
    EXPECT_EQ(s.direction, Vec3f(0, 0, 1));
    EXPECT_TRUE(std::isinf(s.distance));
    EXPECT_EQ(s.radiance, Vec3f(5));
    EXPECT_EQ(light.crossing({7, 8, 9}, {0, 0, 1}).density, 0) << "it is a point of the sky";
}

TEST(Lights, RaysThatMissAllCrossTheDiscOfASun)
{
    WorldLight sun = WorldLight::place({"", SunLight{Vec3f(5)}}, above(100));
    sun.sun_spread = 0.05f;
    const FrameLights lights({sun}, {});
    const auto crossed = [&](Vec3f direction, float t_far, float peak = 1e4f) {
        int count = 0;
        lights.for_crossings({Vec3d(0), glm::normalize(direction), t_far}, peak, {Receiver{}, 1},
                             [&](const WorldLight&, const LightCrossing& c, float) {
                                 EXPECT_NEAR(c.radiance.x, 5 / (kPiD * 0.05 * 0.05), 3);
                                 ++count;
                             });
        return count;
    };
    const float infinity = std::numeric_limits<float>::infinity();
    EXPECT_EQ(crossed({0.049f, 0, 1}, infinity), 1);
    EXPECT_EQ(crossed({0.051f, 0, 1}, infinity), 0);
    EXPECT_EQ(crossed({0, 0, -1}, infinity), 0);
    EXPECT_EQ(crossed({0, 0, 1}, 1e30f), 0) << "something hides it";
    EXPECT_EQ(crossed({0, 0, 1}, infinity, 1), 0) << "a matte surface leaves it to its samples";
    EXPECT_TRUE(lights.leaves_all_to_samples(Vec3d(0), 1, kAllGroups));
    EXPECT_FALSE(lights.leaves_all_to_samples(Vec3d(0), 1e4f, kAllGroups));
}

// Sampled directions pass a chi-square test, and a ray along one of them finds the same light, at the same place, with the
// same density.
TEST(Lights, SampledDirectionsFollowTheDensityThatCrossingRaysAreTold)
{
    WorldLight sun = WorldLight::place({"", SunLight{Vec3f(5)}}, above(1.5));
    sun.sun_spread = 0.8f;
    const WorldLight lights[] = {sun, WorldLight::place(area(AreaLight::Shape::Rectangle, {2, 3}, 1), above(1.5)),
                                 WorldLight::place(area(AreaLight::Shape::Disc, {2, 3}, 1), above(1.5)),
                                 WorldLight::place(area(AreaLight::Shape::Sphere, {2, 2}, 1), above(1.5)),
                                 WorldLight::place(area(AreaLight::Shape::Rectangle, {2, 3}, 1, true), above(-1.5))};
    const Vec3d point(0.4, -0.3, 0.1);
    for (const WorldLight& light : lights) {
        EXPECT_LT(test::direction_excess(
                      60'000, 24,
                      [&](test::Numbers& n) {
                          return light.sample(point, {n.square(), 0}).direction;
                      },
                      [&](Vec3f d) { return light.crossing(point, d).density; }),
                  4.5)
            << int(light.kind);
        test::Numbers numbers(2);
        for (int i = 0; i < 100; ++i) {
            const LightSample s = light.sample(point, {numbers.square() * 0.98f + 0.01f, 0});
            const LightCrossing c = light.crossing(point, s.direction);
            EXPECT_TRUE(std::isinf(s.distance) ? c.distance == s.distance
                                               : std::abs(c.distance - s.distance) <= 2e-4f * s.distance)
                << int(light.kind);
            EXPECT_NEAR(c.density, s.density, 1e-3f * s.density) << int(light.kind);
            EXPECT_NEAR(s.radiance.x * s.density, c.radiance.x, 1e-5f * (1 + c.radiance.x)) << int(light.kind);
        }
    }
}

TEST(Lights, ASceneWithoutLightGetsAKeyLightAndASky)
{
    Scene scene;
    const TextureStore textures(1 << 20);
    const Camera camera = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    const FrameLights dark(scene, camera, textures);
    EXPECT_EQ(dark.lights().size(), 1u);
    EXPECT_FALSE(dark.environment().is_black());
    EXPECT_GT(glm::dot(dark.lights()[0].sample(Vec3d(0), {}).direction, Vec3f(0, 0, 1)), 0) << "from the camera's side";

    NodeDesc lamp;
    lamp.light = scene.add(Light{"lamp", PointLight{}});
    scene.add_node(scene.root(), lamp);
    const FrameLights lit(scene, camera, textures);
    EXPECT_EQ(lit.lights().size(), 1u);
    EXPECT_TRUE(lit.environment().is_black());
}

// A figure with glowing eyes keeps the default light, but a bright ceiling is a lamp. Power compared with size decides, at
// any scale, and for meshes and cages alike.
TEST(Lights, GlowingDetailsDoNotTurnOffTheDefaultLight)
{
    const TextureStore textures(1 << 20);
    const Camera camera = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    for (const Scheme scheme : {Scheme::Triangles, Scheme::Bilinear})
        for (const float scale : {1e-3f, 1.0f, 1e4f})
            for (const bool is_lamp : {false, true}) {
                Scene scene;
                const auto add_square = [&](float half, float height, float emission) {
                    Cage cage;
                    cage.scheme = scheme;
                    cage.positions = {
                        {-half, height, -half}, {half, height, -half}, {half, height, half}, {-half, height, half}};
                    for (Vec3f& p : cage.positions) p *= scale;
                    if (scheme == Scheme::Triangles) cage.face_vertices = {0, 1, 2, 0, 2, 3};
                    else cage.face_vertices = {0, 1, 2, 3}, cage.face_sizes = {4};
                    Material material;
                    material.emission = Vec3f(emission);
                    cage.materials = {scene.add(material)};
                    NodeDesc node;
                    node.cages = {scene.add(std::move(cage))};
                    scene.add_node(scene.root(), node);
                };
                add_square(1, 0, 0);
                add_square(is_lamp ? 0.5f : 0.02f, 1, 2);
                scene.refit();
                const FrameLights lights(scene, camera, textures);
                EXPECT_EQ(lights.lights().empty(), is_lamp) << scale;
                EXPECT_EQ(lights.environment().is_black(), is_lamp) << scale;
                const FrameLights sky(scene, camera, textures, {.sky = Sky::On});
                EXPECT_EQ(sky.lights().empty(), is_lamp) << scale;
                EXPECT_FALSE(sky.environment().is_black());
                const FrameLights none(scene, camera, textures, {.sky = Sky::Off});
                EXPECT_TRUE(none.lights().empty() && none.environment().is_black());
            }
}

// For a sky with one bright patch, the image's own sampling, the surface's lobes and a plain sum over the image's texels
// agree.
TEST(Environment, AnImageIsSampledByItsBrightness)
{
    Scene scene;
    Texture texture;
    texture.width = 64;
    texture.height = 32;
    texture.pixels.assign(64 * 32, Vec4f(0.1f, 0.1f, 0.1f, 1));
    for (int y = 6; y < 10; ++y)
        for (int x = 20; x < 26; ++x) texture.pixels[std::size_t(y * 64 + x)] = Vec4f(50, 50, 50, 1);
    scene.environment.radiance = Vec3f(1);
    scene.environment.image = scene.add(texture);
    TextureStore textures(1 << 24);
    textures.prepare(scene);
    const Environment sky(scene.environment, textures);
    ASSERT_TRUE(sky.has_density());

    Surface s;
    s.diffuse = Vec3f(1);
    s.f0 = Vec3f(0);
    s.f90 = s.dielectric_f0 = s.dielectric_f90 = 0;
    s.to_eye = s.normal = s.normal_geometric = {0, 1, 0};

    double exact = 0;
    constexpr int kFine = 512;
    for (int row = 0; row < kFine; ++row)
        for (int column = 0; column < 2 * kFine; ++column) {
            const double theta = (row + 0.5) / kFine * kPiD, phi = (column + 0.5) / kFine * kPiD;
            const Vec3f d(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                          float(std::sin(theta) * std::sin(phi)));
            exact += double(sky.radiance(d).x * scatter(s, d).x) * std::sin(theta) * (kPiD / kFine) * (kPiD / kFine);
        }
    // Both ways are used together, with one sample from the image and one from the surface.
    test::Numbers numbers(5);
    test::Mean both, image_alone;
    for (int i = 0; i < 20000; ++i) {
        const LightNumbers u{numbers.square(), 0};
        const double drawn = double(test_environment(s, sky, u, {1, 1}).radiance.x);
        const float choice = numbers.one();
        const ScatterSample d = sample_scatter(s, choice, numbers.square());
        const float weight = SampleCounts{1, 1}.of_scatter(d.density, sky.look_up(d.direction).density);
        both.add(drawn + double(d.weight.x * sky.radiance(d.direction).x * weight));
        image_alone.add(double(test_environment(s, sky, u, {1, 0}).radiance.x));
    }
    EXPECT_NEAR(both.value(), exact, 4 * both.error() + 1e-3 * exact);
    EXPECT_LT(both.error(), 0.02 * exact) << "the patch is found often";
    EXPECT_NEAR(image_alone.value(), exact, 4 * image_alone.error() + 1e-3 * exact);
}

TEST(Environment, SampledDirectionsFollowTheirDensity)
{
    Scene scene;
    Texture texture;
    texture.width = 64;
    texture.height = 32;
    for (int k = 0; k < 64 * 32; ++k) {
        const float value = k % 64 > 20 && k % 64 < 30 && k / 64 > 4 && k / 64 < 20 ? 5.0f : 0.4f;
        texture.pixels.push_back(Vec4f(value, value, value, 1));
    }
    scene.environment.radiance = Vec3f(1);
    scene.environment.image = scene.add(texture);
    TextureStore textures(1 << 24);
    textures.prepare(scene);
    const Environment sky(scene.environment, textures);
    EXPECT_LT(test::direction_excess(
                  60'000, 24, [&](test::Numbers& n) { return sky.draw(n.square()).direction; },
                  [&](Vec3f d) { return sky.look_up(d).density; }),
              4.5);
}

TEST(Environment, DirectionsAndTexelsMatch)
{
    Scene scene;
    Texture texture;
    texture.width = 4;
    texture.height = 2;
    texture.pixels.assign(8, Vec4f(0, 0, 0, 1));
    texture.pixels[2] = Vec4f(1, 0, 0, 1);  // this texel is right of the middle, in the upper half
    scene.environment.radiance = Vec3f(1);
    scene.environment.image = scene.add(texture);
    TextureStore textures(1 << 20);
    textures.prepare(scene);
    const Vec3f to_texel = glm::normalize(Vec3f(1, std::sqrt(2.0f), -1));  // u = 5/8, v = 1/4
    EXPECT_NEAR(Environment(scene.environment, textures).radiance(to_texel).x, 1, 1e-3);
    scene.environment.rotation = kPi / 2;  // this turns -z to -x about +y
    const Vec3f turned = glm::normalize(Vec3f(-1, std::sqrt(2.0f), -1));
    EXPECT_NEAR(Environment(scene.environment, textures).radiance(turned).x, 1, 1e-3);
}

}  // namespace
}  // namespace occam::shade
