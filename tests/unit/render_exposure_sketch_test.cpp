// Tests of the sketch that tells how bright a picture is shown, so that the limit of scattered light follows from it.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns a torus under an even sky.
Scene torus_under(float sky)
{
    Scene scene;
    scene.environment.radiance = Vec3f(sky);
    place(scene, scene.add(torus()), Vec3d(0));
    return scene;
}

Settings limited_as_shown(int width, int height)
{
    Settings settings;
    settings.width = width;
    settings.height = height;
    settings.spp = 4;
    settings.clamp = 2;
    settings.clamp_as_shown = true;
    return settings;
}

FrameStats stats_of(Scene& scene, const Settings& settings, const Resources& resources = {.threads = 1})
{
    Renderer renderer(resources);
    renderer.render(scene, Camera::framing(scene.bounds()), settings);
    return renderer.stats();
}

TEST(ExposureSketch, TheLimitIsAMultipleOfTheLightOfTheScene)
{
    const Settings settings = limited_as_shown(48, 32);
    Scene usual = torus_under(0.3f), dark = torus_under(0x1p-8f), darker = torus_under(0x1p-10f);
    EXPECT_EQ(stats_of(usual, settings).settings.clamp, 2) << "it is shown as it is";
    const float limit = stats_of(dark, settings).settings.clamp;
    EXPECT_LT(limit, 0.25f);
    EXPECT_NEAR(stats_of(darker, settings).settings.clamp / limit, 0.25f, 1e-4f);
    // The statistics tell the limit that was used.
    EXPECT_FALSE(stats_of(dark, settings).settings.clamp_as_shown);
}

TEST(ExposureSketch, TheLimitDoesNotDependOnTheCropNorOnTheResources)
{
    Scene scene = torus_under(0x1p-8f);
    Settings settings = limited_as_shown(200, 120);
    const FrameStats whole = stats_of(scene, settings);
    for (const Resources& resources : {Resources{.threads = 3, .workers_a_tree = 0}, Resources{.threads = 2},
                                       Resources{.threads = 1, .tree = accel::TreeKind::Bvh}}) {
        const FrameStats stats = stats_of(scene, settings, resources);
        EXPECT_EQ(stats.settings.clamp, whole.settings.clamp);
        EXPECT_EQ(stats.image.checksum, whole.image.checksum);
    }
    settings.crop_x1 = settings.crop_y1 = 0.25f;  // a corner in which nothing is seen
    EXPECT_EQ(stats_of(scene, settings).settings.clamp, whole.settings.clamp);
}

TEST(ExposureSketch, ASmallPictureBuildsNothingForItsSketchAlone)
{
    Scene scene = torus_under(0x1p-8f);
    Settings settings = limited_as_shown(64, 48);
    const FrameStats with = stats_of(scene, settings);
    settings.clamp = with.settings.clamp;
    settings.clamp_as_shown = false;
    const FrameStats without = stats_of(scene, settings);
    EXPECT_EQ(with.image.checksum, without.image.checksum);
    EXPECT_EQ(with.image.samples, without.image.samples);
    EXPECT_EQ(with.built.visible_cells, without.built.visible_cells);
    EXPECT_GT(with.rays.total(), without.rays.total());
    // The unlimited paths of the sketch may reach a little that the picture does not.
    EXPECT_LE(double(with.built.micropolygons), 1.1 * double(without.built.micropolygons));
}

}  // namespace
}  // namespace occam::test
