// Scenes of any size: a picture has the same bits for every power of two by which a scene is scaled.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "occam/occam.h"
#include "scenegraph/frame_scale.h"
#include "tests/support/campaign.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

Texture bumps(TextureRole role)
{
    Texture texture;
    texture.role = role;
    texture.width = texture.height = 32;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) texture.pixels.push_back(Vec4f(Vec3f(0.5f + 0.03f * float((x * 7 + y * 5) % 16)), 1));
    return texture;
}

Cage floor_mesh(float half)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}};
    cage.face_vertices = {0, 1, 2, 0, 2, 3};
    return cage;
}

/// Holds a scene that is `size` times as large as its original, with lights of every kind, a displaced cage, a bump map, a
/// body of glass that absorbs light, a skinned cage and a glowing mesh.
struct ScaledScene {
    explicit ScaledScene(double size) : size_(size)
    {
        NodeDesc top;
        top.matrix = Mat4d(Mat3d(size));
        (*top.matrix)[3][3] = 1;
        all_ = scene.add_node(scene.root(), top);

        Material plain;
        plain.base_color = {0.7f, 0.6f, 0.5f, 1};
        show(floor_mesh(3), plain, {0, -1, 0});

        Material bumpy = plain;
        bumpy.bump_texture.texture = scene.add(bumps(TextureRole::Data));
        bumpy.bump_scale = float(0.05 * size);
        Cage rough = torus();
        add_charts(rough);
        Displacement moves;
        moves.bound = 0.05f;
        moves.scale = 0.1f;
        moves.texture.texture = bumpy.bump_texture.texture;
        rough.displacement = moves;
        show(rough, bumpy, {-1.2, 0, 0});

        Material glass;
        glass.transmission = 1;
        glass.roughness = 0;
        glass.thickness = 1;
        glass.attenuation_color = {0.4f, 0.8f, 0.9f};
        glass.attenuation_distance = float(0.7 * size);
        show(creased_cube(2), glass, {1.2, 0, 0.6}, 0.6);

        Cage bent = torus();
        add_skin(bent);
        bent.materials = {scene.add(plain)};
        Skin skin;
        for (const Mat4d& joint : bent_joints()) skin.joints.push_back(scene.add_node(all_, {.matrix = joint}));
        scene.add_node(all_, {.cages = {scene.add(std::move(bent))}, .skin = scene.add(skin)});

        Material glow;
        glow.emission = Vec3f(3);
        show(floor_mesh(0.3f), glow, {0.5, 2, -1});
        add_lights();
    }

    Camera camera() const
    {
        Camera camera = Camera::look_at(Vec3d(0.3, 1.5, 5) * size_, Vec3d(0), {0, 1, 0}, 0.8f);
        camera.lens.radius = float(0.03 * size_);
        camera.lens.focus = float(5 * size_);
        return camera;
    }

    Scene scene;

private:
    NodeId show(Cage cage, const Material& material, Vec3d at, double scale = 1)
    {
        cage.materials = {scene.add(material)};
        NodeDesc desc;
        desc.place.translation = at;
        desc.place.scale = Vec3d(scale);
        desc.cages = {scene.add(std::move(cage))};
        return scene.add_node(all_, desc);
    }
    void add_lights()
    {
        const float intensity = float(4 * size_ * size_);
        using Shape = AreaLight::Shape;
        const Vec3f white(1);
        const Light lights[] = {{"point", PointLight{white * intensity}},
                                {"spot", PointLight{white * intensity, float(9 * size_), 0.2f, 0.6f}},
                                {"sun", SunLight{white}},
                                {"rectangle", AreaLight{Shape::Rectangle, Vec2f(1), white}},
                                {"disc", AreaLight{Shape::Disc, Vec2f(0.7f), white}},
                                {"sphere", AreaLight{Shape::Sphere, Vec2f(0.5f), white}}};
        double x = -2;
        for (const Light& light : lights) {
            NodeDesc lamp;
            lamp.place.translation = {x, 3, 0.4 * x};
            lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
            lamp.light = scene.add(light);
            scene.add_node(all_, lamp);
            x += 0.8;
        }
    }

    double size_;
    NodeId all_;
};

Image picture(double size, Settings settings)
{
    ScaledScene scaled(size);
    if (settings.integrator == IntegratorKind::Ao) settings.ao_distance = float(0.8 * size);
    Renderer renderer({.threads = 1});
    return renderer.render(scaled.scene, scaled.camera(), settings);
}

/// Compares the layers of two pictures, of which the second is of a scene `size` times as large.
void expect_same(const Image& original, const Image& scaled, double size)
{
    for (const Layer& layer : original.layers()) {
        const bool is_length = layer.name == "depth" || layer.name == "position";
        const auto &a = layer.pixels, &b = scaled.find(layer.name)->pixels;
        ASSERT_EQ(a.size(), b.size());
        std::size_t differing = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const float expected = is_length ? static_cast<float>(double(a[i]) * size) : a[i];
            differing += std::bit_cast<std::uint32_t>(expected) != std::bit_cast<std::uint32_t>(b[i]);
        }
        EXPECT_EQ(differing, 0u) << layer.name << " of a scene " << size << " times as large";
    }
}

TEST(ScaledScenes, HaveTheSamePictureForEveryPowerOfTwo)
{
    Settings settings{.width = 48, .height = 32, .spp = 4, .integrator = IntegratorKind::Path, .bounces = 3};
    settings.aovs = Aov::Depth | Aov::Normal | Aov::Position | Aov::Albedo;
    for (const ShadeAt at : {ShadeAt::Hit, ShadeAt::Vertex}) {
        settings.shade_at = at;
        const Image original = picture(1, settings);
        for (const double size : {0x1p-40, 0x1p-3, 0x1p40}) expect_same(original, picture(size, settings), size);
    }
    settings.integrator = IntegratorKind::Ao;
    const Image original = picture(1, settings);
    for (const double size : {0x1p-40, 0x1p40}) expect_same(original, picture(size, settings), size);
}

TEST(ScaledScenes, CountLevelsAsThoseOfTheWorld)
{
    ScaledScene small(1), large(0x1p10);
    Renderer renderer({.threads = 1});
    const Settings settings{.width = 32, .height = 24, .spp = 1};
    renderer.render(small.scene, small.camera(), settings);
    const auto of_small = renderer.stats().built.by_level;
    renderer.render(large.scene, large.camera(), settings);
    const auto of_large = renderer.stats().built.by_level;
    ASSERT_EQ(of_small.size(), of_large.size());
    for (const auto& [level, count] : of_small) EXPECT_EQ(of_large.at(level + 10), count);
}

TEST(ScaledScenes, AreFoundByRaysOfQueries)
{
    for (const double size : {0x1p-40, 1.0, 0x1p40}) {
        ScaledScene scaled(size);
        const Query query(scaled.scene, scaled.camera(), 32, std::size_t(1) << 26);
        const auto hit = query.closest(Vec3d(2.5, 0, 2.5) * size, {0, -1, 0}, 4 * size);
        ASSERT_TRUE(hit) << size;
        EXPECT_EQ(hit->distance, size);
        EXPECT_EQ(hit->position, Vec3d(2.5, -1, 2.5) * size);
        EXPECT_FALSE(query.is_occluded(Vec3d(2.5, 0, 2.5) * size, Vec3d(2.5, -0.9, 2.5) * size));
    }
}

/// Sizes that the fault of a missing face, of escaping rays or of black pictures was seen with, and beyond.
TEST(ScaledScenes, LetNoRayOutAtAnySize)
{
    for (const double size : {1e-18, 1e-12, 1e-6, 1e10, 1e12, 1e15}) {
        Cage cage = creased_cube(2);
        for (Vec3f& p : cage.positions) p = Vec3f(Vec3d(p) * size);
        const VerifiedCage report = verify(cage, Mat4d(1), {.rays = is_long() ? 20'480u : 4096u});
        EXPECT_TRUE(report.not_testable.empty()) << size << ": " << report.not_testable;
        EXPECT_GT(report.rays, 0u) << size;
        EXPECT_TRUE(report.holds()) << size << ": " << report.escaped << " escaped";
    }
}

/// Below a light that covers the sky, a white floor is as bright as the light.
TEST(ScaledScenes, AreLitByLightsOfAnySize)
{
    for (const float side : {3e7f, 1e15f}) {
        Scene scene;
        Material white;
        white.base_color = Vec4f(1);
        white.specular = 0;
        Cage floor = floor_mesh(1);
        floor.materials = {scene.add(white)};
        scene.add_node(scene.root(), {.cages = {scene.add(floor)}});
        NodeDesc lamp;
        lamp.place.translation = {0, 1, 0};
        lamp.place.rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476};
        lamp.light = scene.add(Light{"sky", AreaLight{AreaLight::Shape::Rectangle, Vec2f(side), Vec3f(1)}});
        scene.add_node(scene.root(), lamp);
        Renderer renderer({.threads = 1});
        const Image image = renderer.render(scene, Camera::look_at({0, 0.5, 0.01}, Vec3d(0), {0, 1, 0}, 0.5f),
                                            {.width = 16, .height = 16, .spp = 64, .integrator = IntegratorKind::Direct});
        double sum = 0;
        const std::vector<float>& pixels = image.find("beauty")->pixels;
        for (std::size_t i = 0; i < pixels.size(); i += 4) sum += pixels[i];
        EXPECT_NEAR(sum / (double(pixels.size()) / 4), 1, 0.01) << side;
    }
}

TEST(FrameScale, MakesTheLargestSideOneToTwo)
{
    for (const double size : {1e-300, 1e-12, 0.7, 1.0, 3.0, 1e15, 1e300}) {
        const Box3d box{Vec3d(size), {1.5 * size, 3 * size, 2 * size}};
        const Box3d placed = FrameScale(box).placed(box);
        EXPECT_GE(placed.extent().y, 1) << size;
        EXPECT_LT(placed.extent().y, 2) << size;
    }
    const double inf = std::numeric_limits<double>::infinity();
    for (const Box3d& box : {Box3d(), Box3d{Vec3d(3), Vec3d(3)}, Box3d{Vec3d(0), Vec3d(inf)}})
        EXPECT_EQ(FrameScale(box).exponent(), 0);
}

// The unit of a frame follows its largest extent, of which what is near a lamp may be a tiny part.
TEST(FrameScale, LampsShineAsWellInAMuchLargerScene)
{
    for (const bool is_area : {false, true}) {
        double means[3];
        for (const int k : {0, 1, 2}) {
            Scene scene;
            place(scene, scene.add(floor_mesh(1)), Vec3d(0));
            NodeDesc lamp;
            lamp.place.translation = {0, 0.2, 0};
            lamp.place.rotation = {0.7071067811865476, -0.7071067811865476, 0, 0};  // it shines down
            if (is_area)
                lamp.light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(0.1f), Vec3f(3)}});
            else lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(1)}});
            scene.add_node(scene.root(), lamp);
            if (k > 0) place(scene, scene.add(floor_mesh(1)), {k == 1 ? 1e12 : 1e15, 0, 0});
            const Image image = Renderer({.threads = 1})
                                    .render(scene, Camera::look_at({2, 1, 2}, {0, 0, 0}, {0, 1, 0}, 0.4f),
                                            {.width = 16, .height = 16, .spp = 16, .integrator = IntegratorKind::Direct});
            const std::vector<float>& pixels = image.layers()[0].pixels;
            double sum = 0;
            for (std::size_t i = 0; i < pixels.size(); i += 4) sum += double(pixels[i]);
            means[k] = sum / 256;
        }
        EXPECT_GT(means[0], 1e-3) << is_area;
        for (const int k : {1, 2}) EXPECT_NEAR(means[k] / means[0], 1, 0.01) << is_area << ' ' << k;
    }
}

}  // namespace
}  // namespace occam::test
