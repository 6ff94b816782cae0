// A blurred picture is the mean of still pictures of moments while the shutter is open.
//
// Both sides are estimates. The variance of a blurred pixel is known from its own samples, and that of a mean of still
// pictures from how they vary around neighbours of theirs; samples are stratified, so both are bounds from above. A pixel
// fails if the two differ by more than four standard errors and by what many pictures of few moments cannot resolve.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <functional>

#include "tests/support/shape_builders.h"
#include "worm.h"

namespace occam {
namespace {

using namespace test;

struct Moving {
    Scene scene;
    std::function<void(Scene&, double tau)> pose;
    std::function<Camera(double tau)> camera;
    Settings settings{.width = 40, .height = 30, .spp = 64};
};

constexpr int kMoments = 32;

Image blurred(Moving& moving)
{
    Settings settings = moving.settings;
    settings.aovs = Aov::Variance;
    settings.seed = 1000;
    moving.scene.record_shutter(32, [&](double tau) { moving.pose(moving.scene, tau); });
    Camera camera = moving.camera(0.5);
    const Camera first = moving.camera(0), last = moving.camera(1);
    if (first.world_from_camera != last.world_from_camera)
        for (int k = 0; k <= 32; ++k) camera.keys.push_back(moving.camera(k / 32.0).world_from_camera);
    const Image image = Renderer().render(moving.scene, camera, settings);
    moving.scene.clear_shutter();
    return image;
}

double luminance(const float* p) { return 0.2126 * double(p[0]) + 0.7152 * double(p[1]) + 0.0722 * double(p[2]); }

void expect_the_mean_of_stills(Moving moving)
{
    const Image picture = blurred(moving);
    const std::size_t pixels = std::size_t(moving.settings.width * moving.settings.height);
    std::vector<double> sum(pixels), squares(pixels);
    Renderer renderer;
    for (int m = 0; m < kMoments; ++m) {
        const double tau = (m + 0.5) / kMoments;
        moving.pose(moving.scene, tau);
        Settings settings = moving.settings;
        settings.spp = 4;
        settings.seed = std::uint64_t(m);
        const Image still = renderer.render(moving.scene, moving.camera(tau), settings);
        for (std::size_t i = 0; i < pixels; ++i) {
            const double y = luminance(&still.layers()[0].pixels[4 * i]);
            sum[i] += y;
            squares[i] += y * y;
        }
    }
    const std::vector<float>& variance = picture.find("variance")->pixels;
    int exceeding = 0;
    double difference = 0, allowed = 0, blur = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        const double mean = sum[i] / kMoments, found = luminance(&picture.layers()[0].pixels[4 * i]);
        const double of_stills = std::max(0.0, squares[i] / kMoments - mean * mean);  // mostly motion
        const double error2 = double(variance[i]) + of_stills / kMoments;
        exceeding += std::abs(found - mean) > 4 * std::sqrt(error2) + 1e-3;
        difference += found - mean;
        allowed += error2;
        blur += of_stills;
    }
    EXPECT_GT(blur / double(pixels), 1e-4) << "the test needs something that moves";
    // One in 16,000 of normal errors is larger than four standard errors; these have heavier tails.
    EXPECT_LE(exceeding, 2) << "of " << pixels;
    EXPECT_LT(std::abs(difference), 4 * std::sqrt(allowed)) << "over the whole picture";
}

Mat4d turned(double angle)
{
    Mat4d m(1);
    m[0] = Vec4d(std::cos(angle), std::sin(angle), 0, 0);
    m[1] = Vec4d(-std::sin(angle), std::cos(angle), 0, 0);
    return m;
}

Camera front() { return Camera::look_at({0, 0.8, 6}, {0, 0, 0}, {0, 1, 0}, 0.7f); }

// A torus over a floor, under a lamp and a sky.
Moving stage()
{
    Moving moving;
    Scene& scene = moving.scene;
    scene.environment.radiance = Vec3f(0.3f);
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {{-5, -1.5f, -5}, {-5, -1.5f, 5}, {5, -1.5f, 5}, {5, -1.5f, -5}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    scene.add_node(scene.root(), {.cages = {scene.add(floor)}});
    scene.add_node(scene.root(),
                   {.place = {.translation = {0, 5, 0}, .rotation = {-0.7071067811865476, 0, 0, 0.7071067811865476}},
                    .light = scene.add(Light{"lamp", AreaLight{AreaLight::Shape::Rectangle, Vec2f(2), Vec3f(8)}})});
    moving.camera = [](double) { return front(); };
    moving.settings.integrator = IntegratorKind::Path;
    moving.settings.bounces = 2;
    return moving;
}

TEST(MotionBlur, OfACageThatSlides)
{
    Moving moving = stage();
    const NodeId node = place(moving.scene, moving.scene.add(torus()), {0, 0, 0});
    moving.pose = [=](Scene& scene, double tau) {
        scene.set_transform(node, Trs{.translation = {2 * tau - 1, 0.5 * tau, 0}});
    };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfAMeshThatTurns)
{
    Moving moving = stage();
    const NodeId node = moving.scene.add_node(moving.scene.root(), {.cages = {moving.scene.add(spindle(7))}});
    moving.pose = [=](Scene& scene, double tau) { scene.set_transform(node, turned(1.5 * tau)); };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfAWormThatCrawls)
{
    Moving moving = stage();
    const sample::Worm worm = sample::add_worm(moving.scene, {0.3f, 0.6f, 0.9f});
    moving.pose = [=](Scene& scene, double tau) {
        const ClipAt now{worm.crawl, 0.1 + 0.4 * tau};
        scene.pose({&now, 1});
    };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfAMorphAndOfVerticesThatAreWritten)
{
    Moving moving = stage();
    Cage cage = torus();
    MorphTarget grown{"grown", cage.positions, {}};
    for (Vec3f& p : grown.positions) p *= 0.6f;
    cage.morph_targets = {grown};
    const NodeId node = place(moving.scene, moving.scene.add(cage), {-1, 0, 0}, 0.6);
    const CageId waves = moving.scene.add(torus());
    place(moving.scene, waves, {1, 0, 0}, 0.6);
    const std::vector<Vec3f> rest = moving.scene.cage(waves).cage.positions;
    moving.pose = [=](Scene& scene, double tau) {
        scene.set_morph_weights(node, {float(tau)});
        std::vector<Vec3f> positions = rest;
        for (Vec3f& p : positions) p.y += float(tau) * p.x;
        scene.write_vertices(waves, positions);
    };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfWhatIsSeenForAPartOfTheTime)
{
    Moving moving = stage();
    const NodeId node = place(moving.scene, moving.scene.add(torus()), {0, 0, 0});
    moving.pose = [=](Scene& scene, double tau) { scene.set_visible(node, tau < 0.25 || tau >= 0.75); };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfWhatAMirrorThatTurnsShows)
{
    Moving moving = stage();
    Material mirror;
    mirror.metallic = 1;
    mirror.roughness = 0;
    Cage ball = torus(8, 6, false);
    ball.materials = {moving.scene.add(mirror)};
    const NodeId node = place(moving.scene, moving.scene.add(ball), {0, 0, 0});
    const NodeId other = moving.scene.add_node(moving.scene.root(), {.cages = {moving.scene.add(spindle(5))}});
    moving.pose = [=](Scene& scene, double tau) {
        scene.set_transform(node, turned(tau));
        scene.set_transform(other, Trs{.translation = {3 * tau - 1.5, 0, 2.5}, .scale = Vec3d(0.3)});
    };
    expect_the_mean_of_stills(std::move(moving));
}

// The still pictures sample it as a light, and the blurred one finds it by scattered rays. It is large, so that few of these
// miss it.
TEST(MotionBlur, OfAnEmitterThatMoves)
{
    Moving moving = stage();
    Material glow;
    glow.emission = Vec3f(1);
    glow.double_sided = true;
    Cage panel;
    panel.scheme = Scheme::Triangles;
    panel.positions = {{-3, 0, 0}, {3, 0, 0}, {3, 4, 0}, {-3, 4, 0}};
    panel.face_vertices = {0, 1, 2, 0, 2, 3};
    panel.materials = {moving.scene.add(glow)};
    const NodeId node = moving.scene.add_node(moving.scene.root(), {.cages = {moving.scene.add(panel)}});
    moving.settings.spp = 256;
    moving.pose = [=](Scene& scene, double tau) {
        scene.set_transform(node, Trs{.translation = {2 * tau - 1, -1.4, -1.5 + 0.5 * tau}});
    };
    expect_the_mean_of_stills(std::move(moving));
}

TEST(MotionBlur, OfACameraThatFliesWithALens)
{
    for (const float lens : {0.0f, 0.15f}) {
        Moving moving = stage();
        place(moving.scene, moving.scene.add(torus()), {0, 0, 0});
        moving.pose = [](Scene&, double) {};
        moving.camera = [=](double tau) {
            Camera camera = Camera::look_at({tau - 0.5, 0.8, 6 - tau}, {0.2 * tau, 0, 0}, {0, 1, 0}, 0.7f);
            camera.lens.radius = lens;
            camera.lens.focus = 4.5f;
            return camera;
        };
        expect_the_mean_of_stills(std::move(moving));
    }
}

TEST(MotionBlur, OfCameraAndCageTogetherOutOfFocus)
{
    Moving moving = stage();
    const NodeId node = place(moving.scene, moving.scene.add(torus()), {0, 0, 0});
    moving.pose = [=](Scene& scene, double tau) { scene.set_transform(node, Trs{.translation = {0, tau - 0.5, 0}}); };
    moving.camera = [](double tau) {
        Camera camera = Camera::look_at({tau, 0.8, 6}, {0, 0, 0}, {0, 1, 0}, 0.7f);
        camera.lens.radius = 0.2f;
        camera.lens.focus = 3;
        return camera;
    };
    expect_the_mean_of_stills(std::move(moving));
}

}  // namespace
}  // namespace occam
