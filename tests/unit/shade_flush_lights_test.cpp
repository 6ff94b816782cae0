// Lights in the plane of a surface, such as lamps at the height of the ceiling: the surface does not hide them.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>

#include "base/matrix.h"
#include "shade/lights.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam {
namespace {

enum class Kind { Rectangle, Disc, Tube, TwoSided, Point, Spot };
constexpr Kind kKinds[] = {Kind::Rectangle, Kind::Disc, Kind::Tube, Kind::TwoSided, Kind::Point, Kind::Spot};

Light light_of(Kind kind, float size)
{
    if (kind == Kind::Point) return {"", PointLight{.intensity = Vec3f(3)}};
    if (kind == Kind::Spot) return {"", PointLight{.intensity = Vec3f(3), .inner_angle = 0.5f, .outer_angle = 1.2f}};
    AreaLight area;
    area.size = Vec2f(size, kind == Kind::Tube ? size / 80 : size);
    area.shape = kind == Kind::Disc ? AreaLight::Shape::Disc : AreaLight::Shape::Rectangle;
    area.radiance = Vec3f(10);
    area.two_sided = kind == Kind::TwoSided;
    return {"", area};
}

// A floor, with or without a ceiling 1 above it, and lights of one kind in the plane of that ceiling.
struct Hall {
    Kind kind;
    float size = 0.5f;       ///< of the light
    double scale = 1;        ///< of all
    double turn = 0;         ///< about x, radians
    bool is_mirror = false;  ///< the floor is one, and the light is seen in it
    int lights = 1;
    IntegratorKind integrator = IntegratorKind::Path;

    double mean(bool has_ceiling) const
    {
        Scene scene;
        Material white, mirror;
        white.base_color = mirror.base_color = Vec4f(0.8f, 0.8f, 0.8f, 1);
        white.specular = 0;
        mirror.metallic = 1;
        mirror.roughness = 0;
        Cage square;
        square.scheme = Scheme::Triangles;
        square.positions = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
        square.face_vertices = {0, 1, 2, 0, 2, 3};
        NodeDesc all;
        all.place.translation = Vec3d(0.1, 0.2, 0.3) * scale;
        all.place.scale = Vec3d(scale);
        all.place.rotation = {std::sin(turn / 2), 0, 0, std::cos(turn / 2)};
        const NodeId hall = scene.add_node(scene.root(), all);
        NodeDesc flat;
        flat.cages = {scene.add(std::move(square))};
        flat.materials = {scene.add(is_mirror ? mirror : white)};
        scene.add_node(hall, flat);
        flat.materials = {scene.add(white)};
        flat.place.translation = {0, 1, 0};
        if (has_ceiling) scene.add_node(hall, flat);
        NodeDesc lamp;
        lamp.light = scene.add(light_of(kind, size));
        lamp.place.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
        for (int i = 0; i < lights; ++i) {
            lamp.place.translation = {0.3 * (i % 5) - 0.3 * std::min(lights - 1, 2), 1, 0.2 * (i / 5)};
            scene.add_node(hall, lamp);
        }
        const Mat4d world = scene.node(hall).parent_from_node;
        const auto at = [&](double x, double y, double z) { return transform_point(world, Vec3d(x, y, z)); };
        // In the mirror, the light fills the picture.
        const Camera camera = is_mirror ? Camera::look_at(at(0, 0.9, 0), at(0, 0, 0.01), at(0, 0.9, 1) - at(0, 0.9, 0), 0.1f)
                                        : Camera::look_at(at(0, 0.9, 0.9), at(0, 0, 0), at(0, 1, 0) - at(0, 0, 0), 0.9f);
        Settings settings;
        settings.width = settings.height = 24;
        settings.spp = 16;
        settings.bounces = 0;
        settings.integrator = integrator;
        settings.sky = Sky::Off;
        const std::vector<float> pixels = Renderer({.threads = 2}).render(scene, camera, settings).find("beauty")->pixels;
        double sum = 0;
        for (std::size_t i = 0; i < pixels.size(); i += 4) sum += double(pixels[i]);
        return sum * 4 / double(pixels.size());
    }
    /// Returns what part of the light arrives beside the ceiling.
    double share() const
    {
        const double without = mean(false);
        EXPECT_GT(without, 0);
        return mean(true) / without;
    }
};

constexpr double kPlaces[][2] = {{1, 0}, {0.37, 0}, {3.3, 0.6}, {1.7e6, 1.1}, {7.1e-5, -2.3}, {0.9, 2.9}};

TEST(FlushLights, AreNotHiddenByTheSurfaceInTheirPlane)
{
    for (const Kind kind : kKinds)
        for (const float size : {0.5f, 0.02f})
            for (const auto& [scale, turn] : kPlaces)
                EXPECT_NEAR((Hall{.kind = kind, .size = size, .scale = scale, .turn = turn}.share()), 1, 1e-3)
                    << int(kind) << ", size " << size << ", scale " << scale << ", turn " << turn;
}

TEST(FlushLights, AreSeenInMirrors)
{
    for (const Kind kind : {Kind::Rectangle, Kind::Disc, Kind::TwoSided})
        for (const auto& [scale, turn] : kPlaces)
            EXPECT_NEAR((Hall{.kind = kind, .scale = scale, .turn = turn, .is_mirror = true}.share()), 1, 1e-3)
                << int(kind) << ", scale " << scale << ", turn " << turn;
}

TEST(FlushLights, OfATreeAndOfTheDirectIntegratorAreNotHiddenEither)
{
    for (const auto& [scale, turn] : kPlaces)
        for (const IntegratorKind integrator : {IntegratorKind::Path, IntegratorKind::Direct}) {
            const Hall hall{.kind = Kind::Rectangle,
                            .size = 0.15f,
                            .scale = scale,
                            .turn = turn,
                            .lights = 20,
                            .integrator = integrator};
            EXPECT_NEAR(hall.share(), 1, 1e-3) << scale << ' ' << int(integrator);
        }
}

}  // namespace

namespace shade {
namespace {

// A ray from a sample's point along its direction finds the light at the same end and with the same density: also for long
// lights whose sides are sheared, so that the other side leads along the axis, too.
TEST(FlushLights, EndWhereRaysThatCrossThemDo)
{
    for (const AreaLight::Shape shape : {AreaLight::Shape::Rectangle, AreaLight::Shape::Disc})
        for (const double shear : {0.0, 0.3, 1.0, 3.0})
            for (const double width : {1.0, 0.01}) {
                AreaLight area;
                area.shape = shape;
                area.size = Vec2f(1);
                Mat4d m(1);
                m[1] = Vec4d(width * shear, width, 0, 0);
                const WorldLight light = WorldLight::place({"", area}, m);
                EXPECT_EQ(light.is_long, width < 0.1 && shear < 2);
                test::Numbers n(3);
                for (const double height : {0.002, 0.01, 0.05, 0.7})
                    for (int i = 0; i < 200; ++i) {
                        const Vec3d point(0.1, 0, -height);
                        const LightSample s = light.sample(point, {n.square() * 0.98f + 0.01f, n.one()});
                        const LightCrossing c = light.crossing(point, s.direction);
                        if (!(s.direction.z > 0.02f) || (c.density == 0 && height < 0.01)) continue;  // rounded off the rim
                        EXPECT_NEAR(c.density, s.density, 0.01f * s.density) << int(shape) << ", shear " << shear;
                        EXPECT_NEAR(c.distance, s.distance, 1e-3f * s.distance) << int(shape) << ", shear " << shear;
                        const double end = double(s.distance) * double(s.direction.z),
                                     gap = double(LightGap::kOfScene + LightGap::kUlps * s.distance);
                        EXPECT_LT(end, height);
                        EXPECT_GT(end, height - 1.2 * gap);
                    }
            }
}

// Nothing arrives in the plane of a light, or from there, whichever way it is looked for.
TEST(FlushLights, GiveNothingToPlacesInTheirPlane)
{
    AreaLight area;
    area.size = Vec2f(1);
    area.two_sided = true;
    const WorldLight light = WorldLight::place({"", area}, Mat4d(1));
    test::Numbers n(3);
    for (int i = 0; i < 500; ++i) {
        const Vec3d point(n.one() - 0.5f, n.one() - 0.5f, 4e-6 * double(n.one() - 0.5f));
        EXPECT_EQ(light.sample(point, {n.square(), n.one()}).radiance, Vec3f(0));
        EXPECT_EQ(light.crossing(point, glm::normalize(Vec3f(n.one() - 0.5f, n.one() - 0.5f, n.one() - 0.5f))).density, 0);
    }
}

}  // namespace
}  // namespace shade
}  // namespace occam
