// Tests of secondary rays and the surface that they leave: no point of a convex body is shadowed by the body itself, at any
// scale.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "lod/footprint.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

// Returns a cube, whose Catmull-Clark limit surface is convex: each of its points sees a hemisphere of sky.
Cage rounded_cube()
{
    Cage cage;
    for (int i = 0; i < 8; ++i) cage.positions.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    cage.face_sizes.assign(6, 4);
    cage.face_vertices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
    return cage;
}

struct Darkness {
    int pixels = 0;
    double darkest = 1;  ///< least share of the sky that a wholly covered pixel sees
};

Darkness look_at(Scene& scene, const Settings& settings)
{
    const Camera camera = Camera::framing(scene.bounds(), 1);
    Renderer renderer({.threads = 2});
    const Image image = renderer.render(scene, camera, settings);
    const Layer& beauty = *image.find("beauty");
    Darkness result;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4) {
        if (beauty.pixels[i + 3] < 1) continue;
        ++result.pixels;
        result.darkest = std::min(result.darkest, double(beauty.pixels[i]));
    }
    return result;
}

// Each pixel has 64 rays, four from each camera sample. The few that leave below the horizon of their micropolygon, though
// above that of the smooth normal, are not shot: a hundredth where facets are a pixel wide, and more at the rim. One sample
// of sixteen that starts below the surface would cost a sixteenth.
TEST(SelfShadow, AConvexBodySeesAllOfItsSkyAtAnyScale)
{
    EveryNth some(2);
    for (const double away : {0.0, 1e3})
        for (const double scale : {1e-4, 1e-2, 1.0, 1e3, 1e6}) {
            if (!some.takes()) continue;
            Scene scene;
            place(scene, scene.add(rounded_cube()), Vec3d(away * scale, 0, -away * scale), scale);
            Settings settings{.width = 96, .height = 96, .spp = 16};
            settings.background = false;
            settings.integrator = IntegratorKind::Ao;
            settings.light_samples = 4;
            const Darkness seen = look_at(scene, settings);
            EXPECT_GT(seen.pixels, 1000);
            EXPECT_GT(seen.darkest, 0.9375) << "scale " << scale << ", " << away << " sizes from the origin";
        }
}

TEST(SelfShadow, NorDoesItAtAnyShadingRate)
{
    for (const float rate : {0.5f, 4.0f, 16.0f}) {
        Scene scene;
        place(scene, scene.add(rounded_cube()), {0, 0, 0});
        Settings settings{.width = 96, .height = 96, .spp = 16};
        settings.background = false;
        settings.integrator = IntegratorKind::Ao;
        settings.light_samples = 4;
        settings.shading_rate = rate;
        // The normals of facets of sixteen pixels differ by some degrees from one to the next, so as much of the sky is
        // below them.
        EXPECT_GT(look_at(scene, settings).darkest, rate > 8 ? 0.85 : 0.9375) << rate;
    }
}

// A white body under a white sky is white everywhere, however often its light was scattered.
TEST(SelfShadow, AWhiteBodyInAWhiteSkyIsWhite)
{
    for (const double scale : {1e-4, 1.0, 1e6}) {
        Scene scene;
        Material white;
        white.roughness = 0.5f;
        Cage cage = rounded_cube();
        cage.materials = {scene.add(white)};
        place(scene, scene.add(cage), {0, 0, 0}, scale);
        scene.environment.radiance = Vec3f(1);
        Settings settings{.width = 64, .height = 64, .spp = 64};
        settings.background = false;
        settings.integrator = IntegratorKind::Path;
        const Darkness seen = look_at(scene, settings);
        EXPECT_GT(seen.pixels, 500);
        EXPECT_GT(seen.darkest, 0.9) << scale;
    }
}

// Returns the number of pixels that are not black in a room between shells of a rounded cube, seen from inside, with bright
// light outside.
int lit_pixels(const std::vector<double>& shells, double scale, float rate, int bounces)
{
    Scene scene;
    Material material;
    material.roughness = 0.3f;
    Cage cage = rounded_cube();
    cage.materials = {scene.add(material)};
    const CageId id = scene.add(std::move(cage));
    for (const double shell : shells) place(scene, id, {0, 0, 0}, scale * shell);
    scene.environment.radiance = Vec3f(1000);
    for (const Vec3d at : {Vec3d(0, 6, 0), Vec3d(4, 2, 4)}) {
        NodeDesc lamp;
        lamp.place.translation = at * scale;
        lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(float(1000 * scale * scale))}});
        scene.add_node(scene.root(), lamp);
    }
    const Camera camera = Camera::look_at(Vec3d(0.2, 0.1, 0.25) * scale, Vec3d(-0.3, 0.2, -1) * scale, {0, 1, 0}, 1.4f);
    Settings settings{.width = 57, .height = 57, .spp = 16, .integrator = IntegratorKind::Path, .bounces = bounces};
    settings.shading_rate = rate;
    const Image image = Renderer({.threads = 2}).render(scene, camera, settings);
    const Layer& beauty = *image.find("beauty");
    int lit = 0, seen = 0;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4) {
        lit += beauty.pixels[i] > 0 || beauty.pixels[i + 1] > 0 || beauty.pixels[i + 2] > 0;
        seen += beauty.pixels[i + 3] == 1;
    }
    EXPECT_EQ(seen, 57 * 57);
    return lit;
}

// Rays that start where wide beams have hit coarse levels stay inside.
TEST(SelfShadow, AClosedRoomLetsNoLightInHoweverWideItsBeams)
{
    EveryNth some(2);
    for (const float rate : {0.5f, 1.0f, 4.0f}) {
        if (!some.takes()) continue;
        EXPECT_EQ(lit_pixels({1.0}, 1, rate, 6), 0) << rate;
    }
}

// This holds while the target edge length where rays start is at most a quarter of the wall's thickness. Here it is that of
// camera rays at the far wall, up to 1.1 away. The inner shell's limit surface is 0.55 to 0.8 from the middle.
TEST(SelfShadow, AWallLeaksNoLightAtAQuarterOfItsThickness)
{
    EveryNth some(2);
    for (const float rate : {1.0f, 4.0f})
        for (const double scale : {1e-3, 1.0, 1e4}) {
            if (!some.takes()) continue;
            const double edge = 1.1 * 2 * std::tan(0.7) / 57 * double(rate * lod::LevelSettings::kLongestEdge);
            EXPECT_EQ(lit_pixels({1.0, 1 + 4 * edge / 0.55}, scale, rate, 0), 0)
                << "scale " << scale << ", shading rate " << rate;
        }
}

}  // namespace
}  // namespace occam::test
