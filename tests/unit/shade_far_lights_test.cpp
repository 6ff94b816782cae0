// Tests of lights whose places or sizes are beyond the range of floats: none of them makes a sample that is not a number,
// and a frame leaves out those that are too far away, with a warning.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "shade/albedo_table.h"
#include "shade/frame_lights.h"
#include "shade/light_lanes.h"
#include "shade/sheen.h"
#include "tests/support/shape_builders.h"

namespace occam::shade {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

bool is_finite(Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Returns lights of all kinds, among them spots, long lights, and lights without an area.
std::vector<Light> lights_of_all_kinds()
{
    PointLight point, spot;
    point.range = 1e30f;
    spot.outer_angle = 0.9f;
    std::vector<Light> all{{"point", PointLight{Vec3f(1e9f)}}, {"range", point}, {"spot", spot}, {"sun", SunLight{}}};
    for (const AreaLight::Shape shape : {AreaLight::Shape::Rectangle, AreaLight::Shape::Disc, AreaLight::Shape::Sphere})
        for (const Vec2f size : {Vec2f(1), Vec2f(0.5f, 40), Vec2f(1, 0), Vec2f(0), Vec2f(1e38f)})
            for (const bool two_sided : {false, true}) all.push_back({"area", AreaLight{shape, size, Vec3f(1), two_sided}});
    return all;
}

// What lights a small place from afar has a narrow cone.
TEST(FarLights, NarrowSpotsAreFullInsideAndDarkOutside)
{
    for (const double outer : {0.009, 0.02, 0.04, 0.1, 0.5})
        for (const double sharp : {0.0, 0.5, 0.9, 1.0}) {
            PointLight spot{Vec3f(1)};
            spot.outer_angle = static_cast<float>(outer);
            spot.inner_angle = static_cast<float>(outer * sharp);
            const WorldLight light = WorldLight::place({"", spot}, Mat4d(1));
            const auto at = [&](double angle) {
                const double x = std::tan(angle * outer);
                return double(light.sample({x, 0, -1}, {}).radiance.x) * (1 + x * x);
            };
            const double accuracy = 2e-7 / (outer * outer);  // steps of floats are 6e-8, and cones 0.5 outer^2 wide
            EXPECT_NEAR(at(0), 1, accuracy) << outer << " " << sharp;
            EXPECT_NEAR(at(0.96 * std::min(sharp, 0.99)), 1, accuracy) << outer << " " << sharp;
            EXPECT_EQ(at(1.1), 0) << outer << " " << sharp;
        }
}

TEST(FarLights, SampleOfAnyDistanceIsANumberAndHasTheBitsOfALane)
{
    for (const Light& light : lights_of_all_kinds())
        for (const double far : {0.0, 1e-30, 1.0, 1e15, 1e19, 1e20, 1e38, 1e39, 1e155, 1e300, 1e308}) {
            const WorldLight placed = WorldLight::place(light, Mat4d(1));
            const Vec3d point = Vec3d(-0.5, 0.25, -1) * far;
            LanePoints points;
            LaneFloats u, v;
            for (int k = 0; k < kLanes; ++k) {
                points.set(k, point);
                u.of[k] = 0.125f * static_cast<float>(k);
                v.of[k] = 0.75f;
            }
            LightSamples lanes;
            lanes = sample_from(placed, points.to(placed.position), u, v);
            for (int k = 0; k < kLanes; ++k) {
                const LightSample one = placed.sample(point, {{u.of[k], v.of[k]}});
                EXPECT_TRUE(is_finite(one.radiance)) << light.name << ' ' << far;
                EXPECT_TRUE(one.radiance == Vec3f(0) || is_finite(one.direction)) << light.name << ' ' << far;
                EXPECT_EQ(lanes.radiance.at(k), one.radiance) << light.name << ' ' << far;
                if (one.radiance == Vec3f(0)) continue;
                EXPECT_EQ(lanes.direction.at(k), one.direction) << light.name << ' ' << far;
                EXPECT_EQ(lanes.density.of[k], one.density) << light.name << ' ' << far;
            }
        }
}

TEST(FarLights, AreOutOfReachWhereSquaresOverflowAndSunsNever)
{
    for (const Light& light : lights_of_all_kinds())
        for (const double far : {1.0, 1e14, 1e16, 1e39, 1e300, double(INFINITY), double(NAN)}) {
            Mat4d at(1);
            at[3] = Vec4d(3, far, 0, 1);
            EXPECT_EQ(WorldLight::place(light, at).is_in_reach(Vec3d(3, 1, 0)), light.name == "sun" || far < 1e15)
                << light.name << ' ' << far;
        }
}

TEST(FarLights, NodesOfAnyScaleKeepTheirDirectionsAndSizes)
{
    for (const double scale : {1e-200, 1e-160, 1.0, 1e155, 1e200, 1e300}) {
        Mat4d m(0);
        m[0] = Vec4d(0, scale, 0, 0);
        m[1] = Vec4d(0, 0, scale, 0);
        m[2] = Vec4d(scale, 0, 0, 0);
        m[3].w = 1;
        for (const Light& light : {Light{"sun", SunLight{}}, Light{"spot", PointLight{}}, Light{"area", AreaLight{}}})
            EXPECT_EQ(WorldLight::place(light, m).direction, Vec3f(-1, 0, 0)) << light.name << ' ' << scale;
        const WorldLight area = WorldLight::place({"area", AreaLight{}}, m);
        EXPECT_EQ(area.half_x.y, static_cast<float>(std::min(scale / 2, 1e15))) << scale;
    }
}

TEST(Tables, LookUpsOfWhatIsNotANumberStayWithinTheTables)
{
    for (const float x : {kNaN, -kNaN, 1e38f, -1e38f, float(INFINITY), -float(INFINITY)})
        for (const float y : {kNaN, 0.3f, 1e38f}) {
            for (const auto& [cosine, alpha] : {std::pair(x, y), std::pair(y, x)}) {
                Surface cloth;
                cloth.sheen_alpha = alpha;
                const SheenForEye sheen = sheen_for_eye(cloth, cosine);
                EXPECT_TRUE(sheen.reflects >= 0 && sheen.reflects <= 1) << x << ' ' << y;
                EXPECT_TRUE(sheen.scale > 0 && sheen.scale <= 1) << x << ' ' << y;
            }
            const AlbedoTable& table = AlbedoTable::instance();
            const float one = table.at(x, y).sum(), mean = table.mean(x).sum();
            EXPECT_TRUE(one >= 0 && one <= 1.01f) << x << ' ' << y;
            LaneFloats lanes, means;
            lanes = table.at(vfloat(x), AlbedoTable::row_of(vfloat(y))).sum();
            means = table.mean(AlbedoTable::row_of(vfloat(x))).sum();
            EXPECT_EQ(lanes.of[0], one) << x << ' ' << y;
            EXPECT_EQ(means.of[kLanes - 1], mean) << x;
        }
}

// Returns a floor of a unit's size with a field of lamps over it, and a point light at that distance, if it is above zero.
Scene field_of_lamps(double far)
{
    Scene scene;
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {{0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    test::place(scene, scene.add(std::move(floor)), Vec3d(0));
    NodeDesc desc;
    desc.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Sphere, Vec2f(1e-3f), Vec3f(1)}});
    for (int i = 0; i < 400; ++i) {
        desc.place.translation = Vec3d((i % 20 + 0.5) / 20, 0.02, (i / 20 + 0.5) / 20);
        scene.add_node(scene.root(), desc);
    }
    if (far > 0) {
        desc.light = scene.add(Light{"far", PointLight{Vec3f(static_cast<float>(1e-6 * far * far))}});
        desc.place.translation = Vec3d(0.1, 1, 0) * far;
        scene.add_node(scene.root(), desc);
    }
    scene.refit();
    return scene;
}

// Lamps near a point are drawn as often, and a ray crosses the boxes of as few, whatever stands far away.
TEST(FarLights, LeaveLampsThatAreNearApart)
{
    const TextureStore textures(1 << 20);
    const Scene alone = field_of_lamps(0);
    const FrameLights few(alone, {}, textures);
    ASSERT_FALSE(few.tree().is_empty());
    for (const double far : {10.0, 60.0, 70.0, 1e3, 1e5, 1e6, 1e9, 1e14}) {
        const Scene scene = field_of_lamps(far);
        const FrameLights lights(scene, {}, textures);
        ASSERT_EQ(lights.lights().size(), few.lights().size() + 1);
        double sum = 0, of_few = 0;
        for (std::uint32_t i = 3; i < 400; i += 9) {
            const Vec3d point = few.lights()[i].position + Vec3d(0.002, -0.01, 0);
            const auto expected = [&](const FrameLights& of) {
                return double(of.tree().expected(i, {of.tree().relative(point), {0, 1, 0}, kAllGroups, false}, 1));
            };
            sum += expected(lights);
            of_few += expected(few);
            int crossed = 0;
            lights.tree().for_crossed(point, {0, 1, 0}, [&](std::uint32_t) { ++crossed; });
            EXPECT_LE(crossed, 1) << far << ' ' << i;
        }
        EXPECT_GT(sum, 0.9 * of_few) << far;  // the far light changes the order of cuts
    }
}

// Where lights are far away, their tree depends on where the scene is, too.
TEST(FarLights, AreKeptUntilTheSceneIsElsewhere)
{
    std::vector<WorldLight> lights(40);
    for (std::size_t i = 0; i < lights.size(); ++i) {
        lights[i].position = Vec3d(double(i), 2, 0);
        lights[i].strength = Vec3f(1);
    }
    const auto gathered = [&](const KeptLights& last, Vec3d middle) {
        LightGathering gathering(last);
        for (const WorldLight& light : lights) gathering.add(light);
        return gathering.finish(middle);
    };
    const KeptLights near = gathered(nullptr, Vec3d(0));
    EXPECT_EQ(gathered(near, Vec3d(9, 0, 1)), near);
    lights.back().position.y = 1e7;
    const KeptLights far = gathered(near, Vec3d(0));
    EXPECT_EQ(far->tree.origin(), Vec3d(0));
    EXPECT_EQ(gathered(far, Vec3d(1, 0, -1)), far);
    const KeptLights moved = gathered(far, Vec3d(9, 0, 1));
    EXPECT_NE(moved, far);
    EXPECT_EQ(moved->lights.size(), lights.size());
    EXPECT_EQ(moved->tree.origin(), gathered(nullptr, Vec3d(9, 0, 1))->tree.origin());
}

// A surface of each kind of lobe; some of them shade several hits in lanes, and others one by one.
Material cloth(int kind)
{
    Material m;
    if (kind == 1) m.sheen_color = Vec3f(1);
    if (kind == 2) m.clearcoat = 1;
    if (kind == 3) m.anisotropy = 1;
    if (kind == 4) m.transmission = 1;
    return m;
}

TEST(FarLights, AreLeftOutOfPicturesWithAWarning)
{
    for (int kind = 0; kind < 5; ++kind)
        for (const int count : {1, 40}) {
            Scene near, far;
            for (Scene* scene : {&near, &far}) {
                Cage cage = test::torus();
                cage.materials = {scene->add(cloth(kind))};
                test::place(*scene, scene->add(std::move(cage)), Vec3d(0));
                scene->environment.radiance = Vec3f(0.5f);
            }
            const auto lights = lights_of_all_kinds();
            std::size_t left_out = 0;
            for (int i = 0; i < count; ++i)
                for (const double distance : {1e20, 1e39, 1e300}) {
                    const Light& light = lights[static_cast<std::size_t>(i) % lights.size()];
                    if (light.name == "sun") continue;
                    NodeDesc desc;
                    desc.place.translation = Vec3d(0.1 * i, 1, 0.5) * distance;
                    desc.light = far.add(light);
                    far.add_node(far.root(), desc);
                    ++left_out;
                }
            Renderer renderer({.threads = 1});
            const Settings settings{.width = 12, .height = 8, .spp = 4};
            const Camera camera = Camera::framing(near.bounds());
            const std::uint64_t without = renderer.render(near, camera, settings).checksum();
            EXPECT_TRUE(renderer.stats().warnings.empty());
            EXPECT_EQ(renderer.render(far, camera, settings).checksum(), without) << kind << ' ' << count;
            ASSERT_EQ(renderer.stats().warnings.size(), 1u) << kind << ' ' << count;
            EXPECT_NE(renderer.stats().warnings[0].find("times the size of the scene, which were left out: " +
                                                        std::to_string(left_out)),
                      std::string::npos)
                << renderer.stats().warnings[0];
        }
}

}  // namespace
}  // namespace occam::shade
