// Tests of whole paths against closed forms: rooms whose radiance is known, both ways of finding a light, and glass.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam::test {
namespace {

// Returns the same square as level_square(), of 2 side^2 triangles.
Cage tiled_square(float half, std::uint32_t side)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (std::uint32_t j = 0; j <= side; ++j)
        for (std::uint32_t i = 0; i <= side; ++i)
            cage.positions.push_back(half * Vec3f(2 * float(i) / float(side) - 1, 0, 2 * float(j) / float(side) - 1));
    for (std::uint32_t j = 0; j < side; ++j)
        for (std::uint32_t i = 0; i < side; ++i) {
            const std::uint32_t v = j * (side + 1) + i, below = v + side + 1;
            cage.face_vertices.insert(cage.face_vertices.end(), {v, below + 1, v + 1, v, below, below + 1});
        }
    return cage;
}

Material matte(float color)
{
    Material m;
    m.base_color = Vec4f(color, color, color, 1);
    m.specular = 0;
    m.roughness = 1;
    return m;
}

NodeId put(Scene& scene, Cage cage, const Material& material, Vec3d at = Vec3d(0))
{
    cage.materials = {scene.add(material)};
    return place(scene, scene.add(std::move(cage)), at);
}

/// Returns the mean of all pixels, and its standard error.
Mean mean_of(Scene& scene, const Camera& camera, Settings settings)
{
    Renderer renderer({.threads = 2});
    const Image image = renderer.render(scene, camera, settings);
    const Layer& beauty = *image.find("beauty");
    Mean mean;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4) mean.add(double(beauty.pixels[i]));
    EXPECT_EQ(renderer.stats().image.samples_not_finite, 0u);
    return mean;
}

const Settings kSmall{.width = 32, .height = 32, .spp = 64, .integrator = IntegratorKind::Path};
const Camera kInside = Camera::look_at({0.3, 0.2, 0.1}, {1, 0.3, -0.4}, {0, 1, 0}, 1);

// Walls that emit e and reflect rho have a radiance of e / (1 - rho) everywhere, whether samples of lights or bounces find
// it.
TEST(Path, AShiningRoomIsAsBrightAsTheSeriesOfItsBounces)
{
    Scene scene;
    Material walls = matte(0.6f);
    walls.emission = Vec3f(0.4f);
    put(scene, triangle_box(), walls);
    Settings settings = kSmall;
    settings.bounces = 60;
    const Mean all = mean_of(scene, kInside, settings);
    EXPECT_NEAR(all.value(), 1, 4 * all.error() + 1e-3);
    settings.bounces = 1;
    const Mean two = mean_of(scene, kInside, settings);
    EXPECT_NEAR(two.value(), 0.4 * (1 + 0.6 + 0.36), 4 * two.error() + 1e-3)
        << "one bounce, and the light of the last surface";
    settings.integrator = IntegratorKind::Direct;
    const Mean one = mean_of(scene, kInside, settings);
    EXPECT_NEAR(one.value(), 0.4 * (1 + 0.6), 4 * one.error() + 1e-3);
}

// Between a floor and a wide lamp close above it, nearly all directions lead to the lamp. The floor is so large that shadow
// rays start far above it against the height of the lamp.
TEST(Path, ALampLowOverALargeFloorLightsIt)
{
    for (const double height : {1e-2, 1e-3})
        for (const std::uint32_t tiles : {1u, 8u}) {
            Scene scene;
            put(scene, level_square(50), matte(0.5f));
            Material lamp = matte(0);
            lamp.emission = Vec3f(2);
            put(scene, tiled_square(1, tiles), lamp, {0, height, 0});
            const Camera camera = Camera::look_at({0.1, 0.5 * height, 0.2}, {0.1 + 0.1 * height, 0, 0.2}, {0, 0, -1}, 0.7f);
            Settings settings = kSmall;
            settings.integrator = IntegratorKind::Direct;
            const Mean mean = mean_of(scene, camera, settings);
            EXPECT_NEAR(mean.value(), 1, 4 * mean.error() + 2e-3) << height << ' ' << tiles;
        }
}

// The same lamp is an area light of the scene graph and an emissive mesh of few or many triangles. It is near, or so far
// away that the area light is left to its samples, while scattered rays still find the mesh.
TEST(Path, AShiningMeshLightsAsAnAreaLightDoes)
{
    const Camera camera = Camera::look_at({0, 0.8, 0}, {0, 0, 0}, {0, 0, -1}, 1.2f);
    // tiles   along a side of the mesh; 0: an area light
    const auto light = [&](std::uint32_t tiles, float roughness, double height, IntegratorKind integrator) {
        Scene scene;
        Material floor = matte(0.5f);
        floor.specular = 1;
        floor.metallic = 0.5f;
        floor.roughness = roughness;
        put(scene, level_square(4), floor);
        const auto radiance = static_cast<float>(5 * height * height);
        if (tiles > 0) {
            Material lamp = matte(0);
            lamp.emission = Vec3f(radiance);
            put(scene, tiled_square(0.5f, tiles), lamp, {0, height, 0});
        } else {
            NodeDesc lamp;
            lamp.place.translation = {0, height, 0};
            lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
            lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(1), Vec3f(radiance)}});
            scene.add_node(scene.root(), lamp);
        }
        Settings settings = kSmall;
        settings.integrator = integrator;
        return mean_of(scene, camera, settings).value();
    };
    EveryNth some(3);
    for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path})
        for (const double height : {1.0, 9.0})
            for (const float roughness : {0.15f, 1.0f}) {
                if (!some.takes()) continue;
                const double area = light(0, roughness, height, integrator);
                for (const std::uint32_t tiles : {1u, 6u}) {
                    const double mesh = light(tiles, roughness, height, integrator);
                    // The mean is that of 65,536 samples, each of which is right to within a factor.
                    EXPECT_NEAR(area, mesh, 4 * 3e-3 * area) << height << ' ' << roughness << ' ' << tiles;
                }
            }
}

// Light passes a pane straight on and is refracted by a body. Both lose light only by Fresnel reflection.
TEST(Path, GlassInAWhiteSkyIsWhite)
{
    EveryNth some(3);
    for (const float thickness : {0.0f, 1.0f})
        for (const float roughness : {0.0f, 0.1f}) {
            if (!some.takes()) continue;
            Scene scene;
            Material glass;
            glass.roughness = roughness;
            glass.transmission = 1;
            glass.thickness = thickness;
            put(scene, triangle_box(), glass);
            scene.environment.radiance = Vec3f(1);
            Settings settings = kSmall;
            settings.bounces = 128;  // A cube holds light by total reflection for long.
            const Mean m = mean_of(scene, Camera::look_at({2, 3, 4}, {0, 0, 0}, {0, 1, 0}, 0.4f), settings);
            EXPECT_NEAR(m.value(), 1, 4 * m.error() + 2e-3) << thickness << ' ' << roughness;
        }
}

// With no setting but the size, metals, rough panes and rough glass reflect or transmit all light of a white sky.
TEST(Path, ByDefaultMetalsAndRoughGlassAreAsBrightAsTheirSky)
{
    struct Kind {
        const char* name;
        float metallic, transmission, thickness;
    };
    for (const Kind& kind : {Kind{"metal", 1, 0, 0}, Kind{"pane", 0, 1, 0}, Kind{"glass", 0, 1, 1}})
        for (const float roughness : {0.2f, 0.4f, 0.6f, 1.0f}) {
            Scene scene;
            Material material;
            material.metallic = kind.metallic;
            material.transmission = kind.transmission;
            material.thickness = kind.thickness;
            material.roughness = roughness;
            put(scene, triangle_box(), material);
            scene.environment.radiance = Vec3f(1);
            const Mean m = mean_of(scene, Camera::look_at({2, 3, 4}, {0, 0, 0}, {0, 1, 0}, 0.4f),
                                   {.width = 32, .height = 32});
            EXPECT_LT(m.value(), 1 + 4 * m.error() + 0.01) << kind.name << ' ' << roughness;
            // A cube of glass holds some light by total reflection for longer than the default number of bounces.
            const double held = kind.thickness > 0 ? 0.06 : 0.01;
            EXPECT_GT(m.value(), 1 - 4 * m.error() - held) << kind.name << ' ' << roughness;
        }
}

// The transmittance straight through a slab of thickness 2 is exp(-2 a) = 1/2 with a = -ln 0.25 / 4. Reflected light passes
// the slab again.
TEST(Path, ABodyTakesLightByTheLengthOfTheWay)
{
    Scene scene;
    Material glass;
    glass.roughness = 0;
    glass.transmission = 1;
    glass.thickness = 1;
    glass.ior = 1.5f;
    glass.attenuation_color = Vec3f(0.25f);
    glass.attenuation_distance = 4;
    put(scene, triangle_box(), glass);
    scene.environment.radiance = Vec3f(1);
    Settings settings = kSmall;
    settings.bounces = 40;
    // In a narrow view along the axis, with the sky on both sides, the sum over all internal reflections is r + (1 - r)^2 T
    // / (1 - r T), where r = 0.04 and T = 1/2.
    const Mean m = mean_of(scene, Camera::look_at({0, 0, 60}, {0, 0, 0}, {0, 1, 0}, 0.01f), settings);
    const double r = 0.04, t = 0.5;
    const double expected = r + (1 - r) * (1 - r) * (t + r * t * t) / (1 - r * r * t * t);
    EXPECT_NEAR(m.value(), expected, 4 * m.error() + 3e-3);
}

// A lamp hangs in water, 1 above a floor that lies 3 below the surface. The camera looks straight down, and the index is so
// low that nothing is reflected at the surface.
TEST(Path, ABodyTakesLightOnItsWayToALampInside)
{
    const auto water = [](Scene& scene, const Material& floor) {
        Material m = matte(1);
        m.specular = 1;
        m.roughness = 0;
        m.transmission = 1;
        m.thickness = 1;
        m.ior = 1.01f;
        m.attenuation_color = Vec3f(0.5f);
        m.attenuation_distance = 1;
        put(scene, level_square(50), m);
        put(scene, level_square(50), floor, {0, -3, 0});
    };
    Settings settings = kSmall;
    settings.width = settings.height = 8;
    settings.sky = shade::Sky::Off;
    const Camera above = Camera::look_at({0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 0.001f);
    {
        Scene scene;
        water(scene, matte(1));
        NodeDesc lamp;
        lamp.place.translation = {1, -2, 0};  // not in view
        lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(1)}});
        scene.add_node(scene.root(), lamp);
        settings.bounces = 1;
        const double root = std::sqrt(2.0);  // the distance, and one over the cosine
        const double expected = 1 / (2 * root * 3.14159265) * std::exp2(-root - 3);
        EXPECT_NEAR(mean_of(scene, above, settings).value(), expected, 0.01 * expected);
    }
    {
        // A mirror shows the lower side of a lamp, of a radiance of 6.
        Scene scene;
        Material mirror;
        mirror.metallic = 1;
        mirror.roughness = 0;
        water(scene, mirror);
        add_lamp(scene, {0, -2, 0});
        settings.bounces = 4;
        const double expected = 6 * std::exp2(-1 - 3);
        EXPECT_NEAR(mean_of(scene, above, settings).value(), expected, 0.01 * expected);
    }
}

// An unlit surface is no light source, whether or not the scene has one.
TEST(Path, UnlitSurfacesAreSeenAtTheSameStepsBesideAnEmissiveOne)
{
    for (const int bounces : {0, 1})
        for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path}) {
            const auto lit = [&](bool has_emitter) {
                Scene scene;
                put(scene, level_square(3), matte(0.8f));
                Material unlit;
                unlit.unlit = true;
                put(scene, level_square(1), unlit, {0, 1, 0});
                Material shining = matte(0);
                shining.emission = Vec3f(1);
                if (has_emitter) put(scene, level_square(0.1f), shining, {0, -5, 0});
                Settings settings = kSmall;
                settings.integrator = integrator;
                settings.bounces = bounces;
                settings.sky = shade::Sky::Off;
                return mean_of(scene, Camera::look_at({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}, 0.01f), settings);
            };
            const Mean with = lit(true), without = lit(false);
            EXPECT_NEAR(with.value(), without.value(), 4 * (with.error() + without.error())) << bounces;
        }
}

TEST(Path, OneThreadAndManyAndAnyBudgetMakeTheSamePicture)
{
    Scene scene;
    Material glass, gold;
    glass.transmission = glass.thickness = 1;
    glass.roughness = 0.2f;
    gold.metallic = 1;
    gold.roughness = 0.3f;
    put(scene, torus(), gold);
    put(scene, torus(), glass, {1.5, 0.3, 0.2});
    const Camera camera = Camera::framing(scene.bounds());
    Settings settings{.width = 80, .height = 45, .spp = 4, .integrator = IntegratorKind::Path};
    std::uint64_t checksum = 0;
    for (const int threads : {1, 3})
        for (const std::size_t memory : {std::size_t(1) << 30, Renderer({.threads = threads}).memory_floor(scene)}) {
            Renderer renderer({.threads = threads, .memory_bytes = memory});
            const Image image = renderer.render(scene, camera, settings);
            if (checksum == 0) checksum = image.checksum();
            EXPECT_EQ(image.checksum(), checksum) << threads << " threads, " << memory << " bytes";
        }
}

// Adaptive sampling ends where the estimated error is small, and does not change the mean.
TEST(Path, AdaptiveSamplingEndsEarlyWhereLittleIsLeftToFind)
{
    Scene scene;
    put(scene, torus(), matte(0.5f));
    scene.environment.radiance = Vec3f(1);
    const Camera camera = Camera::framing(scene.bounds());
    Settings settings{.width = 64, .height = 36, .spp = 256, .integrator = IntegratorKind::Path};
    Renderer renderer({.threads = 2});
    const Image all = renderer.render(scene, camera, settings);
    const std::uint64_t most = renderer.stats().image.samples;
    EXPECT_EQ(most, 64u * 36 * 256);
    settings.error = 0.02f;
    const Image some = renderer.render(scene, camera, settings);
    EXPECT_LT(renderer.stats().image.samples, most / 2);
    double difference = 0;
    for (std::size_t i = 0; i < all.find("beauty")->pixels.size(); ++i)
        difference += std::pow(double(all.find("beauty")->pixels[i] - some.find("beauty")->pixels[i]), 2);
    EXPECT_LT(std::sqrt(difference / double(all.find("beauty")->pixels.size())), 2 * 0.02);
}

}  // namespace
}  // namespace occam::test
