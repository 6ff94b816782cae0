// Tests of many surfaces that blend or are masked, one behind the other: what they show, and how many rays they take.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "occam/occam.h"
#include "tests/support/plane_stage.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam::render {
namespace {

using Stage = test::PlaneStage;
using test::lambertian;
using test::vertical_sun;

void put_between_white_skies(Stage& stage)
{
    stage.lights.clear();
    occam::Environment uniform;
    uniform.radiance = Vec3f(1);
    stage.environment = shade::Environment(uniform, stage.textures);
}

// Behind many sheets several hits are found at a time, of which no costs are known.
TEST(CostViews, ShowWhatLiesBehindManyTransparentSurfaces)
{
    for (const int layers : {1, 3, 4, 5, 12, 40}) {
        Scene scene;
        Material clear;
        clear.alpha_mode = AlphaMode::Blend;
        clear.base_color.w = 0;
        Cage sheet = test::unit_square(), wall = sheet;
        sheet.materials = {scene.add(clear)};
        const CageId sheets = scene.add(std::move(sheet));
        test::place(scene, scene.add(std::move(wall)), Vec3d(0));
        for (int i = 1; i <= layers; ++i) test::place(scene, sheets, Vec3d(0, 0, 0.01 * i));
        const Camera camera = Camera::look_at({0.5, 0.5, 3}, {0.5, 0.5, 0}, {0, 1, 0}, 0.2f);
        const Image image =
            Renderer({.threads = 1}).render(scene, camera, {.width = 4, .height = 4, .spp = 1, .view = View::Tests});
        const std::vector<float>& pixels = image.layers().front().pixels;
        EXPECT_GT(*std::max_element(pixels.begin(), pixels.begin() + 3), 0) << layers;
    }
}

// Sheets that a mask cuts away hide nothing, in any number, neither from the camera nor from the light.
TEST(Integrator, ThousandsOfMaskedSheetsChangeNothing)
{
    const Material grey = lambertian(0.5f);
    Material leaf = lambertian(0.5f, 0.25f);
    leaf.alpha_mode = AlphaMode::Mask;
    for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path})
        for (const int layers : {31, 32, 33, 4096}) {
            Stage stage;
            stage.settings.integrator = integrator;
            stage.tracer.planes = {{0, &grey}};
            for (int i = 0; i < layers; ++i) {
                stage.tracer.planes.push_back({1 + 3.0 * i / layers, &leaf});
                stage.tracer.planes.push_back({10 + 3.0 * i / layers, &leaf});
            }
            const SampleResult r = stage.one();
            EXPECT_NEAR(r.radiance.x, 0.5f, 1e-5f) << layers;
            EXPECT_EQ(r.alpha, 1) << layers;
            // Rays that pass many sheets find many hits at once.
            EXPECT_LT(stage.counters.rays.primary, 10 + std::uint64_t(layers) / 32);
            EXPECT_LT(stage.counters.rays.shadow, 10 + 2 * std::uint64_t(layers) / 32);
        }
}

// 400 emissive sheets of opacity 1/50 lie over an emissive floor. What the camera sees is right in the mean, though no
// sample follows more than a few branches, and light from above is dimmed by all sheets.
TEST(Integrator, HundredsOfBlendedSheetsAreRightInTheMean)
{
    Material sheet = lambertian(0, 0.02f), floor = lambertian(0);
    sheet.emission = Vec3f(1);
    floor.emission = Vec3f(100);
    Stage stage;
    stage.lights.clear();
    stage.tracer.planes = {{0, &floor}};
    for (int i = 0; i < 400; ++i) stage.tracer.planes.push_back({1 + 3.0 * i / 400, &sheet});
    std::vector<CameraSample> samples;
    for (int i = 0; i < 4096; ++i) samples.push_back({i % 8, i / 8 % 8, i / 64});
    stage.settings.spp = 64;
    const auto results = stage.run(samples);
    double light = 0, alpha = 0;
    for (const SampleResult& r : results) {
        light += double(r.radiance.x) / 4096;
        alpha += double(r.alpha) / 4096;
    }
    const double left = std::pow(0.98, 400);
    EXPECT_NEAR(light, (1 - left) + 100 * left, 0.05);
    EXPECT_NEAR(alpha, 1, 0.02);
    EXPECT_LT(stage.counters.rays.primary, 4096u * 401);
}

// A stack of white sheets scatters all light, so between two skies of radiance 1 it shows 1 everywhere, whatever is lit and
// followed by chance. The stacks are so thin that hardly any light is scattered more than 100 times in them, which is the
// limit here.
TEST(Integrator, FaintWhiteSheetsUnderAWhiteSkyAreWhiteInTheMean)
{
    for (const float alpha : {0.02f, 0.3f}) {
        const Material sheet = lambertian(1, alpha);
        Stage stage;
        put_between_white_skies(stage);
        stage.settings.integrator = IntegratorKind::Path;
        stage.settings.bounces = 100;
        const int sheets = alpha < 0.1f ? 100 : 20;
        for (int i = 0; i < sheets; ++i) stage.tracer.planes.push_back({1 + 3.0 * i / sheets, &sheet});
        std::vector<CameraSample> samples;
        for (int i = 0; i < 1024; ++i) samples.push_back({i % 8, i / 8 % 8, i / 64});
        stage.settings.spp = 16;
        test::Mean mean;
        for (const SampleResult& r : stage.run(samples)) mean.add(double(r.radiance.x));
        EXPECT_NEAR(mean.value(), 1, 4 * mean.error() + 1e-3) << alpha;
        EXPECT_LT(mean.error(), 0.05) << alpha;
    }
}

// A ray that passes many faint surfaces lights a few of them, and its shadow rays end: the rays of a sample do not grow with
// the square of the number of surfaces.
TEST(Integrator, ThousandsOfFaintSheetsTakeFewRays)
{
    for (const float alpha : {0.01f, 1e-4f, 1e-6f}) {
        const Material sheet = lambertian(1, alpha);
        Stage stage;
        stage.settings.integrator = IntegratorKind::Path;
        for (int i = 0; i < 1000; ++i) stage.tracer.planes.push_back({1 + 3.0 * i / 1000, &sheet});
        std::vector<CameraSample> samples;
        for (int i = 0; i < 4; ++i) samples.push_back({i % 8, 4, 0});
        stage.run(samples);
        const RayCounters& rays = stage.counters.rays;
        EXPECT_LT(rays.primary + rays.shadow + rays.diffuse, 4 * 1000u) << alpha;
    }
}

Material clear_pane()
{
    Material pane;
    pane.base_color = Vec4f(1);
    pane.metallic = 0;
    pane.roughness = 0;
    pane.transmission = 1;
    return pane;
}

// In direct light each pane of many is a mirror that shows all others, but those behind the first four are followed by
// chance: a sample follows little more than four paths of at most eight bounces, and not one from each pane that is lit.
TEST(Integrator, ThousandsOfPanesTakeFewRaysInDirectLight)
{
    Material pane = clear_pane();
    pane.alpha_mode = AlphaMode::Blend;
    pane.base_color.a = 0.5f;
    Stage stage;
    stage.settings.integrator = IntegratorKind::Direct;
    for (int i = 0; i < 1000; ++i) stage.tracer.planes.push_back({1 + 3.0 * i / 1000, &pane});
    std::vector<CameraSample> samples;
    for (int i = 0; i < 16; ++i) samples.push_back({i % 8, i / 8, 0});
    stage.run(samples);
    EXPECT_LT(stage.counters.rays.glossy, 16 * 100u);
}

// Clear panes absorb nothing, so between two skies of radiance 1 they show 1 in the mean.
TEST(Integrator, PanesInDirectLightAreRightInTheMean)
{
    const Material pane = clear_pane();
    Stage stage;
    put_between_white_skies(stage);
    stage.settings.integrator = IntegratorKind::Direct;
    stage.settings.bounces = 100;
    for (int i = 0; i < 12; ++i) stage.tracer.planes.push_back({1 + 0.25 * i, &pane});
    std::vector<CameraSample> samples;
    for (int i = 0; i < 4096; ++i) samples.push_back({i % 8, i / 8 % 8, i / 64});
    stage.settings.spp = 64;
    test::Mean mean;
    for (const SampleResult& r : stage.run(samples)) mean.add(double(r.radiance.x));
    EXPECT_NEAR(mean.value(), 1, 4 * mean.error() + 1e-3);
    EXPECT_LT(mean.error(), 0.01);
}

TEST(Integrator, BlendedSheetsBeforeALightAreRightInTheMean)
{
    const Material grey = lambertian(0.5f), sheet = lambertian(0, 0.25f);
    Stage stage;
    stage.lights = {vertical_sun(3.14159265f * 1e6f)};
    stage.tracer.planes = {{0, &grey}};
    for (int i = 0; i < 40; ++i) stage.tracer.planes.push_back({10.0 + i, &sheet});
    std::vector<CameraSample> samples;
    for (int i = 0; i < 65536; ++i) samples.push_back({i % 8, i / 8 % 8, i / 64});
    stage.settings.spp = 1024;
    double light = 0;
    for (const SampleResult& r : stage.run(samples)) light += double(r.radiance.x) / 65536;
    const double expected = 0.5e6 * std::pow(0.75, 40);
    EXPECT_NEAR(light, expected, 0.1 * expected) << "one ray in a hundred gets through";
}

}  // namespace
}  // namespace occam::render
