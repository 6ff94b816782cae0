#include "render/integrator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/plane_stage.h"
#include "tests/support/statistics.h"

namespace occam::render {
namespace {

using Stage = test::PlaneStage;
using test::lambertian;
using test::vertical_sun;

TEST(Integrator, ALitPlaneReflectsItsAlbedo)
{
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.tracer.planes = {{0, &grey}};
    const SampleResult r = stage.one();
    EXPECT_NEAR(r.radiance.x, 0.5f, 1e-5f);  // it is albedo / pi times an irradiance of pi
    EXPECT_EQ(r.alpha, 1);
    EXPECT_EQ(r.albedo, Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_NEAR(r.first.depth, 5, 1e-5);
    EXPECT_EQ(r.first.normal_geometric, Vec3f(0, 1, 0));
    EXPECT_EQ(r.first.id, 8);
    EXPECT_EQ(stage.counters.rays.primary, 1u);
    EXPECT_EQ(stage.counters.rays.shadow, 1u);
}

TEST(Integrator, WhatStandsInTheLightCastsAShadow)
{
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.tracer.planes = {{0, &grey}, {100, &grey}};  // the second plane is above the camera
    EXPECT_EQ(stage.one().radiance, Vec3f(0));
}

TEST(Integrator, AMissIsTransparentOrTheEnvironment)
{
    Stage stage;
    occam::Environment uniform;
    uniform.radiance = Vec3f(2);
    stage.environment = shade::Environment(uniform, stage.textures);
    SampleResult r = stage.one();
    EXPECT_EQ(r.radiance, Vec3f(2));
    EXPECT_EQ(r.alpha, 1);
    EXPECT_EQ(r.albedo.w, 0) << "coverage";
    EXPECT_TRUE(std::isinf(r.first.depth));
    stage.settings.background = false;
    r = stage.one();
    EXPECT_EQ(r.radiance, Vec3f(0));
    EXPECT_EQ(r.alpha, 0);
}

// A path between two planes of that colour meets one of them at each of its scatterings.
std::uint64_t scattered_between_planes(float color, int samples)
{
    const Material material = lambertian(color);
    Stage stage;
    stage.settings.integrator = IntegratorKind::Path;
    stage.settings.bounces = 6;
    stage.settings.spp = samples;
    stage.tracer.planes = {{0, &material}, {6, &material}};
    std::vector<CameraSample> all;
    for (int i = 0; i < samples; ++i) all.push_back({4, 4, i});
    stage.run(all);
    return stage.counters.rays.diffuse;
}

TEST(Integrator, PathsAreEndedByChanceOnlyWhereLittleOfTheirLightIsLeft)
{
    EXPECT_EQ(scattered_between_planes(0.8f, 256), 6u * 256) << "0.8^6 is above a fourth";
    const std::uint64_t dark = scattered_between_planes(0.1f, 256);
    EXPECT_GT(dark, 256u * 3 / 10) << "a tenth is left after the first scattering: two paths in five go on";
    EXPECT_LT(dark, 256u * 5 / 10);
}

// Two sheets of opacity 1/4 lie over a floor. They are unlit, so that none shadows another.
TEST(Integrator, BlendedSheetsAreLaidOverEachOtherInOrder)
{
    Material red = lambertian(0, 0.25f), green = lambertian(0, 0.25f), white = lambertian(1);
    red.base_color.x = green.base_color.y = 1;
    red.unlit = green.unlit = white.unlit = true;
    Stage stage;
    stage.tracer.planes = {{1, &green}, {0, &white}, {2, &red}};
    const SampleResult r = stage.one();
    const float below = 0.75f * 0.75f;
    EXPECT_NEAR(r.radiance.x, 0.25f + below, 1e-6f);
    EXPECT_NEAR(r.radiance.y, 0.75f * 0.25f + below, 1e-6f);
    EXPECT_NEAR(r.radiance.z, below, 1e-6f);
    EXPECT_NEAR(r.alpha, 1, 1e-6f);
    EXPECT_NEAR(r.first.depth, 3, 1e-5) << "of the first sheet";
}

TEST(Integrator, BlendedSheetsLetLightThrough)
{
    const Material grey = lambertian(0.5f), sheet = lambertian(0.5f, 0.25f);
    Stage stage;
    stage.tracer.planes = {{0, &grey}, {50, &sheet}, {60, &sheet}};  // the sheets are above the camera
    EXPECT_NEAR(stage.one().radiance.x, 0.5f * 0.75f * 0.75f, 1e-5f);
    stage.tracer.planes.push_back({70, &grey});
    EXPECT_EQ(stage.one().radiance.x, 0);
}

// Light that was scattered twice is limited, but neither the light of lamps nor that of lit surfaces that the camera sees
// is.
TEST(Integrator, AClampLimitsIndirectLightAlone)
{
    Material mirror = lambertian(1);
    mirror.metallic = mirror.specular = 1;
    mirror.roughness = 0;
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.settings.integrator = IntegratorKind::Path;
    stage.lights = {vertical_sun(3.14159265f * 100)};
    stage.tracer.planes = {{0, &grey}};
    stage.settings.clamp = 2;
    EXPECT_NEAR(stage.one().radiance.x, 50, 1e-3f);
    stage.tracer.planes = {{0, &mirror}, {50, &grey}};
    shade::WorldLight from_below = vertical_sun(3.14159265f * 100);
    from_below.direction = {0, 1, 0};
    stage.lights = {from_below};
    stage.tracer.planes = {{0, &mirror, 0.3}, {50, &grey}};
    stage.settings.bounces = 1;
    stage.settings.clamp = 0;
    EXPECT_GT(stage.one().radiance.x, 10);
    stage.settings.clamp = 2;
    EXPECT_LE(stage.one().radiance.x, 2.001f);
}

TEST(Integrator, ManyLightsAreSampledWithoutBias)
{
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.tracer.planes = {{0, &grey}};
    stage.lights.assign(100, vertical_sun(3.14159265f / 100));
    EXPECT_NEAR(stage.one().radiance.x, 0.5f, 1e-4f);
    EXPECT_EQ(stage.counters.rays.shadow, std::uint64_t(kMaxLightsPerHit));
}

// Lights that are drawn by a tree give what they give in groups that are small enough to do without: lamps near and far,
// found by their samples and by scattered directions, at the first surface and at later ones.
TEST(Integrator, LightsDrawnByATreeGiveTheSumOfAll)
{
    Material glossy = lambertian(0.6f);
    glossy.specular = 1;
    glossy.roughness = 0.4f;
    const Material pane = lambertian(0.6f, 0.7f);
    Stage stage;
    stage.settings.integrator = IntegratorKind::Path;
    stage.settings.bounces = 2;
    stage.settings.spp = 4096;
    stage.tracer.planes = {{0, &glossy}, {-1, &pane}, {40, &glossy}};
    std::vector<shade::WorldLight> lamps;
    for (int i = 0; i < 48; ++i) {
        shade::WorldLight lamp;
        lamp.kind = i % 3 == 0 ? shade::WorldLight::Kind::Sphere : shade::WorldLight::Kind::Rectangle;
        lamp.position = {i % 8 - 3.5, 0.6 + i % 5, i / 8 - 2.5};
        lamp.radius = 0.1f + 0.02f * float(i % 11);
        lamp.direction = {0, i % 4 == 0 ? 1.0f : -1.0f, 0};
        lamp.half_x = {lamp.radius, 0, 0};
        lamp.half_y = {0, 0, 0.3f};
        lamp.area = 4 * lamp.radius * 0.3f;
        lamp.strength = Vec3f(0.1f + float(i % 7));
        lamp.groups = i % 5 == 0 ? LightGroups(2) : kAllGroups;
        lamps.push_back(lamp);
    }
    std::vector<CameraSample> samples;
    for (int i = 0; i < stage.settings.spp; ++i) samples.push_back({2, 5, i});
    const auto mean_of = [&](std::span<const shade::WorldLight> some) {
        stage.lights.assign(some.begin(), some.end());
        test::Mean mean;
        for (const SampleResult& result : stage.run(samples)) mean.add(double(result.radiance.x));
        return mean;
    };
    const test::Mean all = mean_of(lamps);
    double sum = 0, error2 = all.error() * all.error();
    for (std::size_t first = 0; first < lamps.size(); first += 16) {
        const test::Mean some = mean_of(std::span(lamps).subspan(first, 16));
        sum += some.value();
        error2 += some.error() * some.error();
    }
    EXPECT_NEAR(all.value(), sum, 4 * std::sqrt(error2));
    EXPECT_LT(std::sqrt(error2), 0.02 * sum);
}

// One ray is shot towards a lamp for each of its samples, and none is scattered to find the lamp unless it is near.
TEST(Integrator, ALampFarOffIsLeftToItsSamples)
{
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.settings.light_samples = 64;
    stage.tracer.planes = {{0, &grey}};
    shade::WorldLight lamp;
    lamp.kind = shade::WorldLight::Kind::Sphere;
    lamp.radius = 1;
    lamp.strength = Vec3f(1);
    for (const double height : {2.0, 20.0}) {
        lamp.position = {0, height, 0};
        stage.lights = {lamp};
        // The form factor of a sphere straight above is (r / h)^2. The camera's ray hits the plane up to 0.2 beside that
        // point.
        const float expected = 0.5f / static_cast<float>(height * height);
        EXPECT_NEAR(stage.one().radiance.x, expected, 0.03f * expected) << height;
        if (height > 4) EXPECT_EQ(stage.counters.rays.shadow, 64u);
        else EXPECT_GT(stage.counters.rays.shadow, 64u);
    }
}

TEST(Integrator, ABatchDoesNotChangeASample)
{
    const Material grey = lambertian(0.5f), sheet = lambertian(0.7f, 0.5f);
    Stage stage;
    stage.settings.light_samples = 3;
    stage.tracer.planes = {{0, &grey}, {1, &sheet, 0.3}, {8, &grey, 1.0}};
    shade::WorldLight lamp;
    lamp.kind = shade::WorldLight::Kind::Rectangle;
    lamp.position = {0, 20, 0};
    lamp.direction = {0, -1, 0};
    lamp.half_x = {4, 0, 0};
    lamp.half_y = {0, 0, 4};
    lamp.area = 64;
    lamp.strength = Vec3f(2);
    stage.lights = {lamp, vertical_sun(1), lamp};
    stage.environment = shade::Environment::sky();
    std::vector<CameraSample> samples;
    for (int i = 0; i < 8 * 8 * 4 * 16; ++i) samples.push_back({i / 4 % 8, i / 32 % 8, i % 4});
    const auto all = stage.run(samples);
    EXPECT_GT(stage.counters.rays.shadow, FrameContext::kShadowBatch) << "one batch is traced in parts";
    for (std::size_t i = 0; i < samples.size(); i += 97) {
        const auto alone = stage.run({samples[i]});
        EXPECT_EQ(all[i].radiance, alone[0].radiance) << i;
        EXPECT_EQ(all[i].first.depth, alone[0].first.depth) << i;
    }
}

TEST(Integrator, ViewsReplaceLight)
{
    const Material grey = lambertian(0.5f);
    Stage stage;
    stage.tracer.planes = {{0, &grey}};
    stage.settings.view = View::Normal;
    EXPECT_EQ(stage.one().radiance, Vec3f(0.5f, 1, 0.5f));
    EXPECT_EQ(stage.counters.rays.shadow, 0u);
}

}  // namespace
}  // namespace occam::render
