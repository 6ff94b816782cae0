// Tests of cameras that move while the shutter is open, of the moments of samples, and of the motion layer.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cmath>
#include <limits>

#include "render/camera_rays.h"
#include "render/sampler.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam {
namespace {

using namespace test;
using render::CameraRays;
using render::Dimension;
using render::Sampler;

constexpr float kFov = 0.8f;

Camera at_angle(double angle, double height)
{
    return Camera::look_at({5 * std::sin(angle), height, 5 * std::cos(angle)}, {0, 0, 0}, {0, 1, 0}, kFov);
}

// A camera on an arc, and its poses at five keys.
Camera on_an_arc()
{
    Camera camera = at_angle(0.3, 1);
    for (int k = 0; k <= 4; ++k) camera.keys.push_back(at_angle(0.1 + 0.1 * k, 0.5 + 0.25 * k).world_from_camera);
    return camera;
}

Camera still(const Camera& camera, const Mat4d& pose)
{
    Camera copy = camera;
    copy.world_from_camera = pose;
    copy.keys.clear();
    return copy;
}

TEST(MovingCamera, ItsRaysAtAKeyAreThoseOfACameraThatStandsThere)
{
    for (const bool orthographic : {false, true})
        for (const float lens : {0.0f, 0.2f}) {
            Camera camera = on_an_arc();
            camera.lens.orthographic = orthographic;
            camera.lens.height = 3;
            camera.lens.radius = lens;
            camera.lens.focus = 4;
            const CameraRays moving(camera, 64, 36);
            ASSERT_TRUE(moving.moves());
            for (std::size_t k = 0; k < camera.keys.size(); ++k) {
                const CameraRays there(still(camera, camera.keys[k]), 64, 36);
                const float time = float(k) / 4;
                const accel::Ray a = moving.ray(13.25, 30.5, {0.3f, 0.9f}, time), b = there.ray(13.25, 30.5, {0.3f, 0.9f});
                EXPECT_LT(glm::distance(a.origin, b.origin), 1e-12);
                EXPECT_LT(glm::distance(Vec3d(a.direction), Vec3d(b.direction)), 2e-7);
                EXPECT_FLOAT_EQ(a.footprint.b, b.footprint.b);
                EXPECT_EQ(a.time, time);
                EXPECT_NEAR(moving.depth({0.2, 0.1, 0.4}, time), there.depth({0.2, 0.1, 0.4}), 1e-12);
            }
        }
}

// Between two keys that lie 10 degrees apart on a circle, the turn is followed to a hundredth of a pixel.
TEST(MovingCamera, KeepsItsFieldOfViewWhileItTurns)
{
    const auto turned = [](double angle) {
        return Camera::look_at({0, 0, 0}, {std::sin(angle), 0, -std::cos(angle)}, {0, 1, 0}, kFov);
    };
    constexpr double kTurn = 10 * 3.14159265358979 / 180;
    Camera camera = turned(kTurn / 2);
    camera.keys = {turned(0).world_from_camera, turned(kTurn).world_from_camera};
    const CameraRays moving(camera, 1280, 720), middle(turned(kTurn / 2), 1280, 720);
    const double pixel = double(moving.pixel().b);
    for (const Vec2d place : {Vec2d(0, 0), Vec2d(1280, 720), Vec2d(640, 0), Vec2d(0, 360)}) {
        const Vec3d a(moving.ray(place.x, place.y, Vec2f(0.5f), 0.5f).direction);
        const Vec3d b(middle.ray(place.x, place.y).direction);
        EXPECT_LT(glm::distance(a, b), 0.01 * pixel);
    }
}

TEST(MovingCamera, KeysThatAreNoPosesAreRefused)
{
    Scene scene;
    place(scene, scene.add(torus()), {0, 0, 0});
    Renderer renderer;
    const Settings settings{.width = 8, .height = 8, .spp = 1};
    Camera camera = on_an_arc();
    camera.keys[2][3][1] = std::nan("");
    EXPECT_THROW(renderer.render(scene, camera, settings), Error);
    camera.keys.resize(1);
    EXPECT_THROW(renderer.render(scene, camera, settings), Error);
    camera.keys.assign(5000, camera.world_from_camera);
    EXPECT_THROW(renderer.render(scene, camera, settings), Error);
    // Axes that are opposite at two keys, and a camera that jumps far away, still make a picture.
    camera = on_an_arc();
    camera.keys = {camera.world_from_camera, Camera::look_at({0, 0, -5}, {0, 0, 5}, {0, -1, 0}, kFov).world_from_camera,
                   Camera::look_at({1e9, 0, -5}, {0, 0, 5}, {0, -1, 0}, kFov).world_from_camera};
    EXPECT_NO_THROW(renderer.render(scene, camera, settings));
}

// The place in the image at which a ray meets a moving point, a little before and after.
TEST(MotionLayer, IsThePathOfThePictureOfAPoint)
{
    const CameraRays rays(on_an_arc(), 640, 360);
    const Vec3d point(0.3, 0.2, -0.4), velocity(0.5, -1, 0.25);
    const double step = 0.01, time = 0.3;  // away from keys
    const auto place_of = [&](double t) {
        Vec2d place(320, 180);
        for (int n = 0; n < 8; ++n) {  // Newton's method
            const auto off = [&](Vec2d at) {
                const accel::Ray ray = rays.ray(at.x, at.y, Vec2f(0.5f), float(t));
                return Vec3d(ray.direction) - glm::normalize(point + velocity * (t - time) - ray.origin);
            };
            const Vec3d here = off(place), x = off(place + Vec2d(1, 0)) - here, y = off(place + Vec2d(0, 1)) - here;
            const double xx = glm::dot(x, x), xy = glm::dot(x, y), yy = glm::dot(y, y), det = xx * yy - xy * xy;
            const double bx = glm::dot(x, here), by = glm::dot(y, here);
            place -= Vec2d(bx * yy - by * xy, by * xx - bx * xy) / det;
        }
        return place;
    };
    const Vec2d expected = (place_of(time + step) - place_of(time - step)) / (2 * step);
    const Vec2d found = rays.pixel_velocity(point, velocity, float(time));
    EXPECT_GT(glm::length(expected), 10);
    EXPECT_LT(glm::distance(found, expected), 0.01 * glm::length(expected));
    EXPECT_EQ(rays.pixel_velocity({0, 0, 50}, velocity, 0.5f), Vec2d(0)) << "behind the camera";
}

TEST(MotionLayer, IsInPixelsPerFrameToTheRightAndDown)
{
    Scene scene;
    Cage wall;
    wall.scheme = Scheme::Triangles;
    wall.positions = {{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}};
    wall.face_vertices = {0, 1, 2, 0, 2, 3};
    place(scene, scene.add(wall), {0, 0, 0});
    // A camera that moves to the left and up by 1 and 0.5: the wall moves to the right and down.
    Camera camera = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, kFov);
    camera.keys = {camera.world_from_camera, camera.world_from_camera};
    camera.keys[1][3] += Vec4d(-1, 0.5, 0, 0);
    Settings settings{.width = 64, .height = 36, .spp = 4, .aovs = Aov::Motion};
    settings.shutter = {-0.1, 0.4};
    const Image image = Renderer().render(scene, camera, settings);
    const Layer& motion = *image.find("motion");
    ASSERT_EQ(motion.channels, (std::vector<std::string>{"X", "Y"}));
    const double pixels = 18 / std::tan(double(kFov) / 2) / 5;  // for a length of 1
    for (std::size_t i = 0; i < motion.pixels.size(); i += 2) {
        EXPECT_NEAR(double(motion.pixels[i]), pixels / 0.5, 1e-3);
        EXPECT_NEAR(double(motion.pixels[i + 1]), 0.5 * pixels / 0.5, 1e-3);
    }
    settings.shutter = {};
    EXPECT_THROW(Renderer().render(scene, camera, settings), Error);
}

// Each of 2^m equal parts of the shutter has one of 2^m samples of a pixel.
TEST(Sampler, MomentsAreStratified)
{
    const Sampler sampler(3, 16, true);
    for (const std::uint32_t count : {4u, 16u, 64u})
        for (int pixel = 0; pixel < 50; ++pixel) {
            std::vector<int> parts(count);
            for (std::uint32_t s = 0; s < count; ++s)
                ++parts[std::size_t(sampler.interval(pixel, 7, s, Dimension::time()) * float(count))];
            for (const int found : parts) EXPECT_EQ(found, 1);
        }
}

// Pairs of the moment and another number of the same sample: over many pixels, over the samples of one, and the moments of
// neighbouring pixels.
TEST(Sampler, MomentsAreCorrelatedWithNothing)
{
    const Sampler sampler(1, 16, true);
    const std::vector<double> wanted(64, 256.0);
    const auto moment = [&](int x, int y, std::uint32_t s) { return sampler.interval(x, y, s, Dimension::time()); };
    for (const Dimension other : {Dimension::pixel(), Dimension::lens()})
        for (const int axis : {0, 1})
            for (const int way : {0, 1, 2}) {
                std::vector<double> cells(64);
                for (int i = 0; i < 16384; ++i) {
                    // 16384 pixels of a sample each; all samples of one pixel; 16 samples of 1024 pixels.
                    const int pixel = way == 0 ? i : way == 1 ? 5 : i / 16;
                    const auto s = static_cast<std::uint32_t>(way == 0 ? 5 : way == 1 ? i : i % 16);
                    const float a = moment(pixel % 128, pixel / 128, s);
                    const float b = sampler.square(pixel % 128, pixel / 128, s, other)[axis];
                    ++cells[std::size_t(int(a * 8) + 8 * int(b * 8))];
                }
                EXPECT_LT(chi_square_excess(cells, wanted), 4.5) << other.value << ", axis " << axis << ", way " << way;
            }
    std::vector<double> neighbours(64);
    for (int i = 0; i < 16384; ++i)
        ++neighbours[std::size_t(int(moment(2 * (i % 128), i / 128, 3) * 8) +
                                 8 * int(moment(2 * (i % 128) + 1, i / 128, 3) * 8))];
    EXPECT_LT(chi_square_excess(neighbours, wanted), 4.5);
}

// A square that slides past, and a ray at each of three moments.
TEST(Query, SeesTheSceneAtARaysTimeAndTellsTheVelocityOfWhatItHits)
{
    Scene scene;
    Cage square;
    square.scheme = Scheme::Triangles;
    square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    square.face_vertices = {0, 1, 2, 0, 2, 3};
    const NodeId node = place(scene, scene.add(square), {0, 0, 0});
    const auto slide = [&](double tau) { scene.set_transform(node, Trs{.translation = {4 * tau, 0, 2 * tau}}); };
    scene.record_shutter(2, slide);
    const Query query(scene, Camera::look_at({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, kFov));
    for (const float time : {0.0f, 0.375f, 1.0f}) {
        const double x = 4 * double(time) + 0.5;
        const auto hit = query.closest(QueryRay{.origin = {x, 0.2, 9}, .direction = {0, 0, -1}, .time = time});
        ASSERT_TRUE(hit) << time;
        EXPECT_NEAR(hit->distance, 9 - 2 * double(time), 1e-5);
        EXPECT_NEAR(hit->velocity.x, 4, 1e-4);
        EXPECT_NEAR(hit->velocity.y, 0, 1e-4);
        EXPECT_NEAR(hit->velocity.z, 2, 1e-4);
        EXPECT_FALSE(query.closest(QueryRay{.origin = {x, 0.2, 9}, .direction = {0, 0, -1}, .time = 1 - time}) &&
                     std::abs(1 - 2 * double(time)) > 0.9)
            << "the square is elsewhere at that time";
    }
    for (const float time : {-0.1f, 1.1f, std::nanf("")})
        EXPECT_THROW(static_cast<void>(query.closest(QueryRay{.time = time})), Error);
}

// A node whose visibility changes has keys, and then all that they hold is its motion. Its surface lay outside of its bounds
// if a weight was the same at all keys and another one in the middle.
TEST(Query, FindsWhatIsTheSameAtAllKeysWhereTheKeysHaveIt)
{
    for (const bool is_skinned : {false, true}) {
        Scene scene;
        Cage cage = unit_square();
        cage.morph_targets = {{"aside", std::vector<Vec3f>(4, Vec3f(8, 0, 0)), {}}};
        if (is_skinned) {
            cage.skin.sets = 1;
            cage.skin.joints.assign(4, {0, 0, 0, 0});
            cage.skin.weights.assign(4, Vec4f(1, 0, 0, 0));
        }
        const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(cage)}, .morph_weights = {0}});
        if (is_skinned) scene.set_skin(node, scene.add(Skin{{}, {scene.add_node(scene.root(), {})}, {}}));
        const Query query = [&] {
            scene.record_shutter(1, [&](double tau) {
                const double aside = tau == 0.5 ? 1 : 0;
                scene.set_visible(node, tau < 1);
                scene.set_morph_weights(node, {float(aside)});
                if (is_skinned) scene.set_transform(node, moved(0, 8 * aside, 0));
            });
            return Query(scene, at_angle(0, 0));
        }();
        for (const float time : {0.0f, 0.25f, 0.75f}) {
            const QueryRay ray{.origin = {0.3, 0.2, 5}, .direction = {0, 0, -1}, .time = time};
            EXPECT_TRUE(query.closest(ray)) << is_skinned << ", " << time;
            EXPECT_FALSE(query.closest(QueryRay{.origin = {8.3, 0.2, 5}, .direction = {0, 0, -1}, .time = time})) << time;
        }
    }
}

// A picture in which nothing moves is the picture without a shutter, bit for bit.
TEST(Motion, AShutterInWhichNothingMovesLeavesThePictureAsItIs)
{
    Scene scene;
    const NodeId node = place(scene, scene.add(torus()), {0, 0, 0});
    const Camera camera = at_angle(0.3, 1);
    const Settings settings{.width = 48, .height = 32, .spp = 2};
    Renderer renderer;
    const std::uint64_t before = renderer.render(scene, camera, settings).checksum();
    const Mat4d pose = scene.node(node).parent_from_node;
    scene.record_shutter(4, [&](double) { scene.set_transform(node, pose); });
    Settings open = settings;
    open.shutter = {-0.5, 0.5};
    EXPECT_EQ(renderer.render(scene, camera, open).checksum(), before);
    EXPECT_EQ(renderer.stats().motion.segments, 0);
}

// Lights stand still, also in being visible: each shines for the whole shutter or not at all.
TEST(Motion, LightsAreVisibleAsInTheMiddleOfTheShutter)
{
    Scene scene;
    place(scene, scene.add(unit_square()), {0, 0, 0});
    const LightId light = scene.add(Light{{}, PointLight{Vec3f(10)}});
    const NodeId rig = scene.add_node(scene.root(), {}), library = scene.add_node(scene.root(), {.visible = false});
    scene.add_node(rig, {.place = {.translation = {0, 0, 2}}, .light = light});
    scene.add_node(library, {.place = {.translation = {1, 0, 2}}, .light = light});
    const NodeId instance = scene.add_node(scene.root(), {.instance_of = library});
    const Settings settings{.width = 16, .height = 16, .spp = 2, .sky = Sky::Off, .default_light = false};
    Renderer renderer;
    std::uint64_t still[2][2] = {};
    for (const bool a : {false, true})
        for (const bool b : {false, true}) {
            scene.set_visible(rig, a);
            scene.set_visible(instance, b);
            still[a][b] = renderer.render(scene, at_angle(0, 0), settings).checksum();
        }
    EXPECT_NE(still[0][0], still[1][0]);
    EXPECT_NE(still[0][0], still[0][1]);
    for (const double end : {0.4, 0.6}) {
        scene.record_shutter(4, [&](double tau) {
            scene.set_visible(rig, tau < end);
            scene.set_visible(instance, tau >= end);
        });
        EXPECT_EQ(renderer.render(scene, at_angle(0, 0), settings).checksum(), still[end > 0.5][end < 0.5]) << end;
    }
    // A node that comes in the middle of the only segment is shown by none.
    scene.set_visible(instance, false);
    scene.record_shutter(1, [&](double tau) { scene.set_visible(rig, tau >= 0.5); });
    EXPECT_EQ(renderer.render(scene, at_angle(0, 0), settings).checksum(), still[1][0]);
}

// The helper of applications takes as few segments as a quarter of a pixel allows, and all of them for the camera.
TEST(Motion, RecordingChoosesSegmentsByThePixelsOfThePicture)
{
    Scene scene;
    const NodeId node = place(scene, scene.add(torus()), {0, 0, 0});
    const CameraId lens = scene.add(CameraLens{});
    const NodeId dolly = scene.add_node(scene.root(), {.matrix = at_angle(0, 0).world_from_camera, .camera = lens});
    const auto turn = [&](double tau) {
        Mat4d m(1);
        m[0] = Vec4d(std::cos(tau), 0, -std::sin(tau), 0);
        m[2] = Vec4d(std::sin(tau), 0, std::cos(tau), 0);
        scene.set_transform(node, m);
        scene.set_transform(dolly, at_angle(0.2 * tau, 0).world_from_camera);
    };
    const auto camera_of = [&] { return scene.camera().value(); };
    int last = 0;
    for (const int height : {6, 60, 500}) {
        const Camera camera = record_shutter(scene, turn, camera_of, height);
        EXPECT_EQ(camera.keys.size(), 33u);
        EXPECT_GT(scene.shutter_segments(), last);
        last = scene.shutter_segments();
    }
    EXPECT_LE(last, 32);
    EXPECT_EQ(record_shutter(scene, turn, camera_of, 90, 2).keys.size(), 3u);
    EXPECT_EQ(scene.shutter_segments(), 2);
    EXPECT_THROW(record_shutter(scene, turn, camera_of, 0), Error);
    EXPECT_THROW(record_shutter(scene, turn, camera_of, 90, 5), Error);
    EXPECT_THROW(record_shutter(scene, turn, camera_of, 90, -4), Error);
}

// The camera carries a torus along, far away from where it is in the middle of the shutter, and both shake there by a few of
// its pixels.
TEST(Motion, RecordingFollowsWhatACameraCarriesAlong)
{
    Scene scene;
    const NodeId cockpit = scene.add_node(scene.root(), {});
    scene.add_node(cockpit, {.cages = {scene.add(torus())}});
    scene.add_node(cockpit, {.matrix = moved(0, 0, 4), .camera = scene.add(CameraLens{})});
    const auto fly = [&](double tau) {
        const double shaking = tau > 0.75 ? 0.025 * std::sin(25.132741228718345 * tau) : 0;
        scene.set_transform(cockpit, moved(60 * tau, shaking, 0));
    };
    record_shutter(
        scene, fly, [&] { return scene.camera().value(); }, 100);
    EXPECT_GE(scene.shutter_segments(), 16) << "with 8, all keys are where nothing is shaken";
}

}  // namespace
}  // namespace occam
