// Tests of which rays see a node or a side of its surface, and which lights illuminate it: in the tracer, in pictures, in
// files.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <bit>
#include <random>

#include "accel/frame.h"
#include "accel/tracer.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr std::uint8_t kKinds[] = {RayKind::Camera, RayKind::Shadow, RayKind::Reflection, RayKind::Transmission,
                                   RayKind::Diffuse};

// Holds a torus between two prisms that span the scene's bounds, and another torus inside it; the first one may be left out.
struct Toruses {
    Scene scene;
    lod::TopologyCache topologies;
    NodeId outer, inner;

    explicit Toruses(bool has_outer)
    {
        const CageId span = scene.add(prism(5));
        place(scene, span, {-3, -1, -3}, 0.3);
        place(scene, span, {3, 1, 3}, 0.3);
        inner = place(scene, scene.add(torus(7, 4)), {0, 0, 0}, 0.8);
        const CageId cage = scene.add(torus());
        if (has_outer) outer = place(scene, cage, {0, 0, 0});
        scene.refit();
    }
    std::vector<float> distances(std::span<const accel::Ray> rays, bool is_alone = false)
    {
        const accel::Frame frame(scene, topologies, {.eye = Vec3d(0), .pixel = {std::ldexp(1.0f, -4), 0}});
        accel::Tracer tracer(frame, std::size_t(1) << 30);
        std::vector<accel::SurfaceHit> hits(rays.size());
        if (!is_alone) tracer.closest(rays, hits);
        else
            for (std::size_t i = 0; i < rays.size(); ++i) tracer.closest({&rays[i], 1}, {&hits[i], 1});
        std::vector<std::uint8_t> occluded(rays.size());
        tracer.occluded(rays, occluded);
        std::vector<float> t;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            t.push_back(hits[i].t);
            EXPECT_EQ(hits[i].is_hit(), occluded[i] != 0) << "ray " << i;
        }
        return t;
    }
};

std::vector<accel::Ray> rays_of_all_kinds()
{
    std::mt19937_64 random(3);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
    std::vector<accel::Ray> rays(10'000);
    for (accel::Ray& ray : rays) {
        ray.origin = {0.4, 3, 2.5};
        ray.direction = Vec3f(glm::normalize(Vec3d(3 * uniform() - 1.5, uniform() - 0.5, 3 * uniform() - 1.5) - ray.origin));
        ray.kinds = kKinds[random() % std::size(kKinds)];
    }
    return rays;
}

TEST(Visibility, RaysPassWhatIsHiddenFromThemAsIfItWereNotThere)
{
    const std::vector<accel::Ray> rays = rays_of_all_kinds();
    Toruses both(true), without(false), flagged(true);
    const std::vector<float> all = both.distances(rays), inner = without.distances(rays);
    for (const std::uint8_t kind : kKinds) {
        flagged.scene.set_seen_by(flagged.outer, static_cast<std::uint8_t>(RayKind::All & ~kind));
        for (const bool is_alone : {false, true}) {
            const std::vector<float> found = flagged.distances(rays, is_alone);
            int differ = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const float wanted = rays[i].kinds == kind ? inner[i] : all[i];
                ASSERT_EQ(std::bit_cast<std::uint32_t>(found[i]), std::bit_cast<std::uint32_t>(wanted)) << "ray " << i;
                differ += found[i] != all[i];
            }
            EXPECT_GT(differ, 300);
        }
    }
}

TEST(Visibility, AFlagHoldsForTheSubtreeAndForInstances)
{
    const std::vector<accel::Ray> rays = rays_of_all_kinds();
    Toruses below(true), without(false);
    NodeDesc group;
    group.seen_by = 0;
    group.instance_of = below.outer;
    below.scene.add_node(below.scene.root(), group);
    below.scene.set_visible(below.outer, false);
    EXPECT_EQ(below.distances(rays), without.distances(rays));
}

Cage floor_of(float half)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
    cage.face_vertices = {0, 2, 1, 0, 3, 2};
    return cage;
}

NodeId add_light(Scene& scene, Vec3d at, Light light)
{
    NodeDesc node;
    node.place.translation = at;
    node.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};  // the light shines downwards
    node.light = scene.add(std::move(light));
    return scene.add_node(scene.root(), node);
}

Vec3f middle(Scene& scene, IntegratorKind integrator = IntegratorKind::Direct, int light_samples = 1)
{
    const Settings settings{.width = 1, .height = 1, .spp = 16, .integrator = integrator, .light_samples = light_samples};
    const Image image =
        Renderer({.threads = 1}).render(scene, Camera::look_at({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 0.01f), settings);
    const auto& p = image.find("beauty")->pixels;
    return {p[0], p[1], p[2]};
}

// A lid lies between camera and floor, and under a lamp. It is visible, or casts a shadow, or both, or neither.
TEST(Visibility, ALidHiddenFromTheCameraStillCastsItsShadow)
{
    Scene scene;
    place(scene, scene.add(floor_of(3)), {0, 0, 0});
    const NodeId lid = place(scene, scene.add(floor_of(0.5f)), {0, 1, 0});
    add_light(scene, {0, 4, 0}, {"lamp", PointLight{Vec3f(10)}});
    const float seen = middle(scene).x;
    scene.set_seen_by(lid, RayKind::All & ~RayKind::Camera);
    EXPECT_EQ(middle(scene).x, 0) << "the floor's shadow";
    scene.set_seen_by(lid, RayKind::All & ~(RayKind::Camera | RayKind::Shadow));
    const float lit = middle(scene).x;
    EXPECT_GT(lit, 0);
    scene.set_seen_by(lid, RayKind::All & ~RayKind::Shadow);
    EXPECT_EQ(middle(scene).x, seen) << "16/9 as bright as the floor, being nearer";
    EXPECT_NEAR(seen, lit * 16 / 9, 1e-4f * seen);
}

// The lid lies between floor and sky, which scattered rays find alone. They are blocked by what they may hit, at the last
// step of a path as at any other, whether or not something else shines.
TEST(Visibility, ScatteredRaysToTheSkyAreNoShadowRays)
{
    for (const bool has_emitter : {false, true})
        for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path}) {
            Scene scene;
            scene.environment.radiance = Vec3f(1);
            Material black, shining;
            black.base_color = shining.base_color = Vec4f(0, 0, 0, 1);
            black.specular = shining.specular = 0;
            shining.emission = Vec3f(1);
            Cage cage = floor_of(3), wide = floor_of(100), far_off = floor_of(0.1f);
            wide.materials = {scene.add(black)};
            far_off.materials = {scene.add(shining)};
            place(scene, scene.add(std::move(cage)), {0, 0, 0});
            const NodeId lid = place(scene, scene.add(std::move(wide)), {0, 3, 0});
            if (has_emitter) place(scene, scene.add(std::move(far_off)), {0, -5, 0});
            scene.set_seen_by(lid, RayKind::All & ~RayKind::Shadow);
            EXPECT_LT(middle(scene, integrator).x, 0.02f) << has_emitter;
            scene.set_seen_by(lid, RayKind::Shadow);
            EXPECT_GT(middle(scene, integrator).x, 0.5f) << has_emitter;
        }
}

// Shadow rays would reach the far side of the box through its near side, which scattered rays cannot.
TEST(Visibility, AnEmissiveMeshThatCastsNoShadowShinesAsAnyOther)
{
    for (const bool is_metal : {false, true}) {
        Scene scene;
        Material m, shining;
        m.specular = 0;
        m.metallic = is_metal ? 1.0f : 0.0f;
        m.roughness = is_metal ? 0.5f : 1.0f;
        shining.emission = Vec3f(9);
        shining.base_color = Vec4f(0, 0, 0, 1);
        shining.specular = 0;
        Cage floor = floor_of(3), lamp = triangle_box();
        floor.materials = {scene.add(m)};
        lamp.materials = {scene.add(shining)};
        place(scene, scene.add(std::move(floor)), {0, 0, 0});
        const NodeId box = place(scene, scene.add(std::move(lamp)), {0.3, 1.2, 0.1}, 0.2);
        const auto lit = [&](std::uint8_t seen_by, int light_samples) {
            scene.set_seen_by(box, seen_by);
            const Settings settings{.width = 4,
                                    .height = 4,
                                    .spp = 1024 / light_samples,
                                    .bounces = 0,
                                    .light_samples = light_samples,
                                    .sky = shade::Sky::Off};
            const Camera camera = Camera::look_at({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}, 0.01f);
            double sum = 0;
            const Image image = Renderer({.threads = 1}).render(scene, camera, settings);
            for (std::size_t i = 0; i < 64; i += 4) sum += double(image.find("beauty")->pixels[i]) / 16;
            return sum;
        };
        const double all = lit(RayKind::All, 1);
        EXPECT_GT(all, 0.02);
        // One sample of a light is drawn for several surfaces in lanes, and more for each surface alone.
        for (const int light_samples : {1, 4})
            EXPECT_NEAR(lit(RayKind::All & ~RayKind::Shadow, light_samples), all, 0.02 * all) << is_metal;
    }
}

// A surface that shines but is hidden from the rays that would find its light does not light what scatters those. Nothing
// is lost where other rays find it.
TEST(Visibility, AnEmissiveMeshLightsByTheRaysThatSeeIt)
{
    for (const bool is_metal : {false, true}) {
        Scene scene;
        Material m, shining;
        m.specular = 0;
        m.metallic = is_metal ? 1.0f : 0.0f;
        m.roughness = is_metal ? 0.1f : 1.0f;  // so smooth that hardly any light is scattered twice by the metal
        shining.emission = Vec3f(1);
        Cage floor = floor_of(3), lamp = floor_of(1);
        floor.materials = {scene.add(m)};
        lamp.materials = {scene.add(shining)};
        place(scene, scene.add(std::move(floor)), {0, 0, 0});
        const CageId cage = scene.add(std::move(lamp));
        NodeDesc group;
        const NodeId above = scene.add_node(scene.root(), group);
        NodeDesc desc;
        desc.cages = {cage};
        desc.place.translation = {0, 1, 0};
        const NodeId node = scene.add_node(above, desc);
        const auto lit = [&](std::uint8_t seen_by) {
            scene.set_seen_by(above, seen_by);
            const Settings settings{.width = 4, .height = 4, .spp = 256, .bounces = 0, .sky = shade::Sky::Off};
            const Camera camera = Camera::look_at({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}, 0.01f);
            double sum = 0;
            const Image image = Renderer({.threads = 1}).render(scene, camera, settings);
            for (std::size_t i = 0; i < 64; i += 4) sum += double(image.find("beauty")->pixels[i]) / 16;
            return sum;
        };
        const std::uint8_t needed = is_metal ? RayKind::Reflection : RayKind::Diffuse;
        const double all = lit(RayKind::All);
        EXPECT_GT(all, 0.2);
        EXPECT_NEAR(lit(needed), all, 0.01 * all) << is_metal;
        EXPECT_NEAR(lit(static_cast<std::uint8_t>(RayKind::All & ~needed)), 0, 0.01 * all) << is_metal;
        // An instance that all rays see shows the same node.
        NodeDesc instance;
        instance.instance_of = node;
        instance.place.translation = {0, 1, 0};
        scene.add_node(scene.root(), instance);
        scene.set_visible(above, false);
        EXPECT_NEAR(lit(RayKind::All & ~needed), all, 0.01 * all) << is_metal;
    }
}

// Both ways of finding an area light respect the groups: rough surfaces sample it, and mirrors hit it.
TEST(Visibility, ALightLightsWhatIsLitByItsGroup)
{
    for (const float roughness : {0.02f, 1.0f})
        for (const IntegratorKind integrator : {IntegratorKind::Direct, IntegratorKind::Path}) {
            Scene scene;
            Material metal;
            metal.metallic = 1;
            metal.roughness = roughness;
            Cage cage = floor_of(3);
            cage.materials = {scene.add(metal)};
            const NodeId floor = place(scene, scene.add(std::move(cage)), {0, 0, 0});
            add_light(scene, {0, 3, 0}, {"red", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(1, 0, 0)}, 1});
            add_light(scene, {0, 4, 0}, {"green", AreaLight{AreaLight::Shape::Rectangle, Vec2f(3), Vec3f(0, 1, 0)}, 2});
            const Vec3f both = middle(scene, integrator, 16);
            scene.set_lit_by(floor, 2);
            const Vec3f green = middle(scene, integrator, 16);
            EXPECT_GT(both.x, 0.05f);
            EXPECT_EQ(green.x, 0) << roughness;
            EXPECT_EQ(green.y, both.y) << roughness;
            scene.set_lit_by(floor, 4);
            EXPECT_EQ(middle(scene, integrator, 16), Vec3f(0)) << roughness;
        }
}

TEST(Visibility, FilesSayWhoSeesANodeAndWhatLightsIt)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"extras": {"occam": {"hidden_from": ["camera", "shadow"], "lit_by": ["key", "rim"]}}},
                 {"extras": {"occam": {"area_light": {"shape": "disc"}, "light_group": "rim"}}},
                  {"extras": {"occam": {"area_light": {"shape": "disc"}}}})";
    Scene scene = load(g.write(folder));
    std::vector<const Node*> nodes;
    scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d&) {
        if (id != scene.root()) nodes.push_back(&node);
    });
    ASSERT_EQ(nodes.size(), 3u);
    EXPECT_EQ(nodes[0]->seen_by, RayKind::Reflection | RayKind::Transmission | RayKind::Diffuse);
    EXPECT_EQ(nodes[1]->seen_by, RayKind::All);
    EXPECT_EQ(std::popcount(nodes[0]->lit_by), 2);
    EXPECT_EQ(nodes[1]->lit_by, kAllGroups);
    EXPECT_EQ(std::popcount(scene.light(nodes[1]->light).groups), 1);
    EXPECT_NE(scene.light(nodes[1]->light).groups & nodes[0]->lit_by, 0u);
    EXPECT_EQ(scene.light(nodes[2]->light).groups, kAllGroups) << "a light without a group lights everything";
}

// Settings::back_faces = false: rays pass the backs of single-sided surfaces as if these were not there.

enum class Facing { Up, Down };

NodeId add_square(Scene& scene, float half, double height, const Material& material, Facing facing = Facing::Up)
{
    NodeDesc desc;
    desc.place.translation = {0, height, 0};
    if (facing == Facing::Down) desc.place.rotation = {1, 0, 0, 0};  // half a turn about x
    Cage cage = floor_of(half);
    cage.materials = {scene.add(Material(material))};
    desc.cages = {scene.add(std::move(cage))};
    return scene.add_node(scene.root(), desc);
}

Material diffuse_only(float color)
{
    Material m;
    m.base_color = Vec4f(color, color, color, 1);
    m.specular = 0;
    return m;
}

// Returns what a camera sees that looks straight down.
float seen_from_above(Scene& scene, double height)
{
    const Settings settings{.width = 1, .height = 1, .spp = 64, .sky = shade::Sky::Off, .back_faces = false};
    const Camera camera = Camera::look_at({0, height, 0}, {0, 0, 0}, {0, 0, -1}, 0.01f);
    return Renderer({.threads = 1}).render(scene, camera, settings).find("beauty")->pixels[0];
}

// Scattered rays meet the lamp and then the back of the ceiling behind it.
TEST(BackFaces, ALampBeforeABackIsFoundAsWithoutIt)
{
    const auto floor_under = [](bool has_ceiling) {
        Scene scene;
        add_square(scene, 3, 0, diffuse_only(0.8f));
        add_lamp(scene, {0, 1, 0});
        const NodeId ceiling = add_square(scene, 3, 1.2, diffuse_only(0));
        scene.set_visible(ceiling, has_ceiling);
        return seen_from_above(scene, 0.5);
    };
    const float without = floor_under(false);
    EXPECT_GT(without, 0.4f);
    EXPECT_NEAR(floor_under(true), without, 1e-4f);
}

TEST(BackFaces, ABodyTakesLightOnBothSidesOfABackInIt)
{
    const auto through_body = [](bool has_back) {
        Scene scene;
        scene.environment.radiance = Vec3f(1);
        Material body = diffuse_only(1);
        body.transmission = 1;
        body.thickness = 1;
        body.roughness = 0;
        body.ior = 1.01f;  // hardly any light is reflected to the front of what is in the body
        body.attenuation_color = Vec3f(0.5f);
        body.attenuation_distance = 1;
        add_square(scene, 3, 0, body);
        add_square(scene, 3, -1, body, Facing::Down);
        const NodeId back = add_square(scene, 3, -0.9, diffuse_only(0), Facing::Down);
        scene.set_visible(back, has_back);
        return seen_from_above(scene, 2);
    };
    const float without = through_body(false);
    EXPECT_NEAR(without, 0.5f, 1e-3f);
    EXPECT_NEAR(through_body(true), without, 1e-3f);
}

TEST(BackFaces, OfEmissiveSurfacesShedNoLight)
{
    const auto floor_under = [](Facing facing, bool is_double_sided, Vec3d scale = Vec3d(1)) {
        Scene scene;
        add_square(scene, 3, 0, diffuse_only(0.8f));
        Material shining = diffuse_only(0);
        shining.emission = Vec3f(1);
        shining.double_sided = is_double_sided;
        Trs placed;
        placed.translation = {0, 1, 0};
        placed.scale = scale;
        if (facing == Facing::Down) placed.rotation = {1, 0, 0, 0};
        scene.set_transform(add_square(scene, 1, 1, shining), placed);
        return seen_from_above(scene, 0.5);
    };
    EXPECT_EQ(floor_under(Facing::Up, false), 0);
    EXPECT_GT(floor_under(Facing::Down, false), 0.4f);
    EXPECT_GT(floor_under(Facing::Up, true), 0.4f);
    // A mirror image has its front where the mirror shows it.
    EXPECT_EQ(floor_under(Facing::Down, false, {1, -1, 1}), 0);
    EXPECT_EQ(floor_under(Facing::Up, false, {-1, 1, 1}), 0);
    EXPECT_GT(floor_under(Facing::Up, false, {1, -1, 1}), 0.4f);
    EXPECT_GT(floor_under(Facing::Down, false, {-1, 1, 1}), 0.4f);
}

}  // namespace
}  // namespace occam::test
