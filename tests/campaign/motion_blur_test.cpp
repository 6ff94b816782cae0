// A blurred picture is the mean of still pictures of moments while the shutter is open (tests/support/mean_of_stills.h).
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <algorithm>
#include <cmath>

#include "tests/support/mean_of_stills.h"
#include "tests/support/shape_builders.h"
#include "worm.h"

namespace occam {
namespace {

using namespace test;

void expect_the_mean_of_stills(Moving moving)
{
    const BlurComparison found = compare_with_stills(moving);
    EXPECT_GT(found.blur, 1e-4) << "the test needs something that moves";
    // One in 16,000 of normal errors is larger than four standard errors; these have heavier tails.
    EXPECT_LE(found.exceeding, 2u) << "of " << found.pixels;
    EXPECT_LT(std::abs(found.difference), 4 * found.error) << "over the whole picture";
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

/// Returns the part of a pixel's samples that see a bar, if each moment of the shutter is as likely as any other. The bar is
/// `width` pixels wide, and its left side goes from `start` by `way` pixels to the right at one speed.
double coverage_of(int pixel, double start, double width, double way)
{
    constexpr int kPlaces = 64;
    double sum = 0;
    for (int k = 0; k < kPlaces; ++k) {
        const double x = pixel + (k + 0.5) / kPlaces;
        const double comes = std::clamp((x - start - width) / way, 0.0, 1.0), goes = std::clamp((x - start) / way, 0.0, 1.0);
        sum += (goes - comes) / kPlaces;
    }
    return sum;
}

enum class Slides { Node, Vertices, Camera };

/// Expects the closed form of a shining square that slides before nothing, where each unit of the world is a pixel.
void expect_coverage(Slides how, int segments)
{
    constexpr int kColumns = 40, kRows = 12, kSamples = 256;
    constexpr double kStart = 6, kWidth = 7, kWay = 22;
    Scene scene;
    Material shining;
    shining.emission = Vec3f(1);
    shining.base_color = Vec4f(0, 0, 0, 1);
    Cage square;
    square.scheme = Scheme::Triangles;
    square.positions = {{0, -50, 0}, {kWidth, -50, 0}, {kWidth, 50, 0}, {0, 50, 0}};
    square.face_vertices = {0, 1, 2, 0, 2, 3};
    square.materials = {scene.add(shining)};
    const std::vector<Vec3f> rest = square.positions;
    const CageId cage = scene.add(std::move(square));
    const NodeId node = place(scene, cage, {kStart, 0, 0});
    Camera camera = Camera::look_at({kColumns / 2, 0, 10}, {kColumns / 2, 0, 0}, {0, 1, 0}, 0.5f);
    camera.lens.orthographic = true;
    camera.lens.height = kRows;
    scene.record_shutter(segments, [&](double tau) {
        if (how == Slides::Node) scene.set_transform(node, Trs{.translation = {kStart + kWay * tau, 0, 0}});
        std::vector<Vec3f> moved = rest;
        for (Vec3f& p : moved) p.x += static_cast<float>(kWay * tau);
        if (how == Slides::Vertices) scene.write_vertices(cage, moved);
    });
    for (int k = 0; k <= segments && how == Slides::Camera; ++k) {
        camera.keys.push_back(camera.world_from_camera);
        camera.keys.back()[3].x -= kWay * k / segments;
    }
    const Settings settings{.width = kColumns, .height = kRows, .spp = kSamples, .integrator = IntegratorKind::Direct};
    const Image image = Renderer().render(scene, camera, settings);
    for (int x = 0; x < kColumns; ++x) {
        const double wanted = coverage_of(x, kStart, kWidth, kWay);
        // Moments and places are stratified, so this is a bound of the deviation from above.
        const double deviation = std::sqrt(std::max(wanted * (1 - wanted), 0.0) / kSamples);
        double column = 0;
        for (int y = 0; y < kRows; ++y) {
            const double seen = image.layers()[0].pixels[std::size_t(4 * (y * kColumns + x))];
            EXPECT_NEAR(seen, wanted, 4 * deviation + 1e-6) << "pixel " << x << ", " << y;
            column += seen / kRows;
        }
        EXPECT_NEAR(column, wanted, 4 * deviation / std::sqrt(kRows) + 1e-6) << "column " << x;
    }
}

// How long a pixel sees the square is known without any picture: moments are as dense at each time of the shutter.
TEST(MotionBlur, OfASquareThatSlidesIsHowLongEachPixelSeesIt)
{
    for (const Slides how : {Slides::Node, Slides::Vertices, Slides::Camera})
        for (const int segments : {1, 4}) {
            SCOPED_TRACE("way " + std::to_string(int(how)) + ", segments " + std::to_string(segments));
            expect_coverage(how, segments);
        }
}

// A rod of four sides, a few pixels thick, flies along itself: its silhouettes stay where they are, and so blur hides
// nothing of what long edges would cut off. The picture is compared with that of a cage of full detail, which a frame with a
// camera for levels has.
TEST(MotionBlur, OfThinCagesKeepsTheirThickness)
{
    const Camera far = Camera::look_at({0, 0, 40}, {0, 0, 0}, {0, 1, 0}, 0.1f);
    Scene scene;
    Cage rod;
    for (int ring = 0; ring < 9; ++ring)
        for (int k = 0; k < 4; ++k)
            rod.positions.push_back({0.75f * float(ring) - 3, k == 0 || k == 3 ? -0.08f : 0.08f, k < 2 ? -0.08f : 0.08f});
    for (std::uint32_t ring = 0; ring < 8; ++ring)
        for (std::uint32_t k = 0; k < 4; ++k)
            for (const std::uint32_t v :
                 {4 * ring + k, 4 * ring + 4 + k, 4 * ring + 4 + (k + 1) % 4, 4 * ring + (k + 1) % 4})
                rod.face_vertices.push_back(v);
    rod.face_sizes.assign(32, 4);
    const NodeId node = place(scene, scene.add(rod), {0, 0, 0});
    scene.record_shutter(1, [&](double tau) { scene.set_transform(node, Trs{.translation = {4 * tau - 2, 0, 0}}); });
    Settings settings{.width = 96, .height = 72, .spp = 8};
    settings.integrator = IntegratorKind::Direct;
    settings.background = false;
    double covered[2]{};
    for (const int is_fine : {0, 1}) {
        settings.lod_camera = is_fine ? std::optional(far) : std::nullopt;
        const Image image = Renderer().render(scene, far, settings);
        for (std::size_t i = 3; i < image.layers()[0].pixels.size(); i += 4)
            covered[is_fine] += double(image.layers()[0].pixels[i]);
    }
    EXPECT_GT(covered[1], 150);
    EXPECT_NEAR(covered[0] / covered[1], 1, 0.02);
}

// Cages that fly by 200 pixels have long edges where few samples tell them from short ones. Pictures of many seeds are
// compared with those of cages of full detail, which a frame with a camera for levels has.
TEST(MotionBlur, OfCagesWithLongEdgesIsNearlyThatOfFineOnes)
{
    constexpr int kPictures = 8;
    Moving moving = stage();
    const Camera far = Camera::look_at({0, 1.6, 12}, {0, 0, 0}, {0, 1, 0}, 0.35f);
    const CageId cage = moving.scene.add(torus(9, 5, false));
    std::vector<NodeId> nodes;
    for (int k = 0; k < 2; ++k) nodes.push_back(place(moving.scene, cage, {0, 2.0 * k - 1, 0}, 2));
    moving.scene.record_shutter(1, [&](double tau) {
        for (int k = 0; k < 2; ++k)
            moving.scene.set_transform(nodes[std::size_t(k)],
                                       Trs{.translation = {5 * tau - 2.5, 2.0 * k - 1, 0}, .scale = Vec3d(2)});
    });
    Settings settings{.width = 256, .height = 192, .spp = 8};
    settings.integrator = IntegratorKind::Direct;
    const std::size_t pixels = std::size_t(settings.width * settings.height);
    std::vector<double> sum[2] = {std::vector<double>(pixels), std::vector<double>(pixels)}, squares = sum[0];
    std::uint64_t micropolygons[2]{};
    for (const int is_fine : {0, 1})
        for (int k = 0; k < kPictures; ++k) {
            settings.seed = std::uint64_t(1000 * is_fine + k);
            settings.lod_camera = is_fine ? std::optional(far) : std::nullopt;
            Renderer renderer;
            const Image image = renderer.render(moving.scene, far, settings);
            micropolygons[is_fine] = renderer.stats().built.micropolygons;
            for (std::size_t i = 0; i < pixels; ++i) {
                const double y = image.layers()[0].pixels[4 * i + 1];
                sum[is_fine][i] += y / kPictures;
                squares[i] += y * y / kPictures;
            }
        }
    double difference = 0, noise = 0, mean[2]{};
    for (std::size_t i = 0; i < pixels; ++i) {
        const double d = sum[0][i] - sum[1][i];
        difference += d * d / double(pixels);
        noise += (squares[i] - sum[0][i] * sum[0][i] - sum[1][i] * sum[1][i]) / (kPictures - 1) / double(pixels);
        for (const int k : {0, 1}) mean[k] += sum[k][i] / double(pixels);
    }
    EXPECT_LT(3 * micropolygons[0], 2 * micropolygons[1]);
    EXPECT_LT(std::abs(mean[0] / mean[1] - 1), 0.002);
    // The root of the mean squared difference, without its noise, is less than a quarter of the standard deviation of a
    // pixel in one picture.
    EXPECT_LT(difference - noise, noise * (kPictures / 2) / 16);
}

}  // namespace
}  // namespace occam
