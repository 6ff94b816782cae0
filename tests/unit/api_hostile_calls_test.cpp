// Tests of calls to the facade with values at the ends of their ranges, and from several threads at once.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "occam/occam.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

const Camera kBefore = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f);

// Holds a cube as a Catmull-Clark cage, which is nearly a ball of radius 0.8 of its half side.
struct Ball {
    Scene scene;

    Ball()
    {
        NodeDesc desc;
        desc.cages = {scene.add(test::creased_cube(0))};
        scene.add_node(scene.root(), desc);
    }
};

TEST(Query, DirectionsMayHaveAnyLength)
{
    Ball ball;
    const Query query(ball.scene, kBefore);
    const Vec3d from(0.1, 0.2, 5), way(0.01, -0.02, -1);
    const std::optional<Hit> hit = query.closest(from, way);
    ASSERT_TRUE(hit);
    for (const int exponent : {-1000, -600, -300, 300, 600, 1000}) {
        const Vec3d scaled = way * std::ldexp(1.0, exponent);
        const std::optional<Hit> same = query.closest(from, scaled);
        ASSERT_TRUE(same) << exponent;
        EXPECT_EQ(same->distance, hit->distance) << exponent;
        EXPECT_TRUE(query.is_occluded({from, scaled})) << exponent;
    }
    EXPECT_TRUE(query.closest(from, {0, 0, -5e-324})) << "the least direction of all";
    for (const Vec3d none : {Vec3d(0), Vec3d(0, 0, -HUGE_VAL), Vec3d(NAN, 0, -1)})
        EXPECT_FALSE(query.closest(from, none).has_value());
}

// Rays of one packet end one by one: what is wrong with one of them may not decide where the others end.
TEST(Query, ARayThatIsNotANumberHitsNothingAndLeavesItsNeighboursAlone)
{
    Ball ball;
    const Query query(ball.scene, kBefore);
    std::vector<QueryRay> rays;
    for (int i = 0; i < 64; ++i) rays.push_back({{0.01 * (i % 8), 0.01 * (i / 8), 5}, {0, 0, -1}, 20});
    std::vector<FirstHit> wanted(rays.size()), found(rays.size());
    query.first_hits(rays, wanted);
    for (const FirstHit& hit : wanted) ASSERT_TRUE(std::isfinite(hit.distance));
    for (const int field : {0, 1, 2, 3, 4, 5, 6})
        for (const double bad : {double(NAN), -double(NAN)})
            for (std::size_t at = 0; at < rays.size(); ++at) {
                std::vector<QueryRay> asked = rays;
                QueryRay& ray = asked[at];
                (field < 3 ? ray.origin[field] : field < 6 ? ray.direction[field - 3] : ray.far) = bad;
                query.first_hits(asked, found);
                EXPECT_FALSE(query.closest(ray).has_value()) << field;
                EXPECT_FALSE(query.is_occluded(ray)) << field;
                for (std::size_t i = 0; i < asked.size(); ++i)
                    if (i == at) EXPECT_TRUE(std::isinf(found[i].distance)) << field;
                    else EXPECT_EQ(found[i].distance, wanted[i].distance) << field << ": " << at << ' ' << i;
            }
    for (const Vec2d place : {Vec2d(NAN, 3), Vec2d(3, NAN), Vec2d(INFINITY, 3)})
        EXPECT_FALSE(query.pick(place.x, place.y, 64).has_value());
}

// The ray that is far away has every place of a packet in turn.
TEST(Query, ARayFromVeryFarAwayLeavesItsNeighboursAlone)
{
    Ball ball;
    const Query query(ball.scene, kBefore);
    std::vector<QueryRay> rays;
    for (int i = 0; i < 64; ++i) rays.push_back({{0.01 * (i % 8), 0.01 * (i / 8), 5}, {0.1, 0.05, -1}});
    std::vector<FirstHit> wanted(rays.size()), found(rays.size());
    query.first_hits(rays, wanted);
    for (const double away : {1e10, 1e29, 1e39, 1e60, 1e200})
        for (std::size_t at = 0; at < rays.size(); ++at) {
            std::vector<QueryRay> asked = rays;
            asked[at].origin -= asked[at].direction * away;
            query.first_hits(asked, found);
            for (std::size_t i = 0; i < asked.size(); ++i)
                ASSERT_TRUE(i == at || found[i].distance == wanted[i].distance) << away << ": " << at << ' ' << i;
        }
}

TEST(Query, WritesNoHitIfOneOfTheRaysIsRefused)
{
    Ball ball;
    const Query query(ball.scene, kBefore);
    std::vector<QueryRay> rays(5000, QueryRay{{0, 0, 5}, {0, 0, -1}});
    std::vector<FirstHit> found(rays.size());
    for (const int field : {0, 1, 2}) {
        std::vector<QueryRay> asked = rays;
        if (field == 0) asked.back().time = NAN;
        if (field == 1) asked.back().footprint = RayFootprint{NAN, 0};
        if (field == 2) asked.back().kinds = 0;
        EXPECT_THROW(query.first_hits(asked, found), Error) << field;
        for (const FirstHit& hit : found) ASSERT_FALSE(hit.node) << field;
    }
}

// The camera's footprint is wide here, so that it is told from none.
TEST(Query, AFootprintOfZeroIsNotThatOfTheCamera)
{
    Ball ball;
    const Query query(ball.scene, kBefore, 8);
    const auto distance = [&](std::optional<RayFootprint> footprint) {
        QueryRay ray{{0.1, 0.2, 5}, {0, 0, -1}};
        ray.footprint = footprint;
        return query.closest(ray).value().distance;
    };
    EXPECT_EQ(distance(RayFootprint{0, 0}), distance(RayFootprint{1e-20f, 0}));
    EXPECT_EQ(distance(RayFootprint{1e-45f, 0}), distance(RayFootprint{1e-20f, 0}));
    EXPECT_NE(distance(RayFootprint{0, 0}), distance({}));
}

// The camera is far away, so that its pixels are wide where the other rays start.
TEST(Query, RaysThatStartAnywhereHitWhatThePictureShows)
{
    Ball ball;
    const Vec3d eye(0, 0, 100), way = glm::normalize(Vec3d(0.003, -0.002, -1));
    const Query query(ball.scene, Camera::look_at(eye, {0, 0, 0}, {0, 1, 0}, 0.8f), 256);
    const std::optional<Hit> shown = query.closest(eye, way);
    ASSERT_TRUE(shown);
    for (const double before : {0.5, 1.0, 10.0}) {
        const std::optional<Hit> hit = query.closest(shown->position - way * before, way);
        ASSERT_TRUE(hit) << before;
        EXPECT_NEAR(hit->distance, before, 1e-5) << before;
    }
}

// The texture of the displacement does not fit the renderer's memory, and so the picture is displaced by a smaller one.
TEST(Query, OfARendererHitsTheDisplacedSurfaceThatItsPictureShows)
{
    constexpr int kSide = 64;
    Scene scene;
    Texture noise;
    noise.role = TextureRole::Data;
    noise.width = noise.height = kSide;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) noise.pixels.push_back(Vec4f(float((i * 2654435761u) >> 24) / 255));
    Cage square = test::textured_square();
    Displacement displacement;
    displacement.texture.texture = scene.add(std::move(noise));
    displacement.scale = 0.4f;
    displacement.bound = 0.2f;
    square.displacement = displacement;
    NodeDesc desc;
    desc.cages = {scene.add(std::move(square))};
    scene.add_node(scene.root(), desc);
    Renderer renderer({.threads = 1, .texture_bytes = 4096});
    Image image = renderer.render(scene, kBefore,
                                  {.width = kSide, .height = kSide, .spp = 1, .jitter = false, .aovs = Aov::Depth});
    const Query query(renderer, scene, kBefore, kSide);
    for (int at = 20; at < 44; ++at) {
        const std::optional<Hit> hit = query.pick(at + 0.5, at + 0.5, kSide);
        ASSERT_TRUE(hit) << at;
        EXPECT_NEAR(5 - hit->position.z, double(image.layer(1).pixels[std::size_t(at * kSide + at)]), 1e-5) << at;
    }
}

TEST(Query, PicksWhatLiesBehindThePlaneOfFocus)
{
    Ball ball;
    Camera sharp = kBefore, lens = kBefore;
    lens.lens.radius = 0.5f;
    const auto picked = [&](const Camera& camera) { return Query(ball.scene, camera, 64).pick(30.2, 33.7, 64); };
    ASSERT_TRUE(picked(sharp));
    for (const int blades : {0, 5})
        for (const float focus : {1.0f, 4.5f, 20.0f}) {
            lens.lens.focus = focus;
            lens.lens.blades = blades;
            ASSERT_TRUE(picked(lens)) << focus;
            EXPECT_EQ(picked(lens)->distance, picked(sharp)->distance) << focus;
        }
}

TEST(Api, AnEnvironmentOfAnotherSceneIsRefused)
{
    Ball ball;
    Scene other;
    Texture texture;
    texture.width = texture.height = 1;
    texture.pixels = {Vec4f(1)};
    ball.scene.environment.image = other.add(texture);
    Renderer renderer({.threads = 1});
    std::ostringstream out;
    EXPECT_THROW(renderer.render(ball.scene, kBefore, {.width = 4, .height = 4}), Error);
    EXPECT_THROW(renderer.replay(ball.scene, kBefore, {.width = 4, .height = 4}, {}, out), Error);
    ball.scene.environment.image = ball.scene.add(texture);
    EXPECT_NO_THROW(renderer.render(ball.scene, kBefore, {.width = 4, .height = 4}));
}

// It would otherwise displace as a white one does.
TEST(Api, ADisplacementByADeadOrForeignTextureIsRefused)
{
    Scene scene, other;
    Texture texture;
    texture.pixels = {Vec4f(0)};
    texture.width = texture.height = 1;
    const TextureId own = scene.add(texture), removed = scene.add(texture), foreign = other.add(texture);
    scene.remove(removed);
    Cage cage = test::prism(5);
    const auto displaced_by = [&](TextureId id) {
        cage.displacement.emplace().texture.texture = id;
        return cage;
    };
    const CageId id = scene.add(displaced_by(own));
    EXPECT_NO_THROW(scene.add(displaced_by({})));
    for (const TextureId wrong : {removed, foreign}) {
        EXPECT_THROW(scene.add(displaced_by(wrong)), Error);
        EXPECT_THROW(scene.replace(id, displaced_by(wrong)), Error);
    }
    EXPECT_EQ(scene.cage(id).cage.displacement->texture.texture, own);
    EXPECT_THROW(scene.remove(own), Error) << "the cage still uses it";
}

TEST(Api, AJobCanBeWaitedForWithoutEnd)
{
    Ball ball;
    Renderer renderer({.threads = 1});
    const Job job = renderer.start(ball.scene, kBefore, {.width = 64, .height = 64, .spp = 64});
    EXPECT_FALSE(job.wait_for(std::chrono::milliseconds::min()));
    EXPECT_TRUE(job.wait_for(std::chrono::milliseconds::max()));
}

TEST(Api, AShutterNeedsACamera)
{
    Scene scene;
    EXPECT_THROW(record_shutter(
                     scene, [](double) {}, nullptr, 100),
                 Error);
}

// Each of them finds the scene dirty. Its groups have so many children that their boxes are in trees.
TEST(Api, RenderersBeginFramesOfOneSceneAtOnce)
{
    Ball ball;
    const CageId cage = ball.scene.node(ball.scene.node(ball.scene.root()).children.front()).cages.front();
    std::vector<NodeId> nodes;
    for (int group = 0; group < 40; ++group) {
        const NodeId above = ball.scene.add_node(ball.scene.root(), {});
        for (int k = 0; k < 100; ++k) nodes.push_back(ball.scene.add_node(above, {.cages = {cage}}));
    }
    const Settings settings{.width = 4, .height = 4, .spp = 1};
    for (int frame = 0; frame < (test::is_long() ? 20 : 6); ++frame) {
        for (std::size_t k = 0; k < nodes.size(); ++k)
            ball.scene.set_transform(
                nodes[k], Trs{.translation = {std::sin(double(k) + frame), std::cos(double(k)), 1}, .scale = Vec3d(0.01)});
        std::uint64_t checksums[2] = {};
        std::atomic<int> ready{0};
        const auto render = [&](std::uint64_t& checksum) {
            Renderer renderer({.threads = 1});
            for (++ready; ready < 2;) std::this_thread::yield();
            checksum = renderer.render(ball.scene, kBefore, settings).checksum();
        };
        std::thread elsewhere(render, std::ref(checksums[0]));
        render(checksums[1]);
        elsewhere.join();
        EXPECT_EQ(checksums[0], checksums[1]) << frame;
    }
}

TEST(Api, AShutterIsNotRecordedIntoAFrameThatItsPoseHasBegun)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(test::torus())}});
    std::optional<Scene::FrameLock> frame;
    const auto pose = [&](double tau) {
        if (!frame) scene.set_transform(node, test::moved(tau, 0, 0));
        if (tau == 1) frame.emplace(scene);
    };
    EXPECT_THROW(scene.record_shutter(2, pose), Error);
    frame.reset();
    EXPECT_EQ(scene.shutter_segments(), 0);
}

TEST(Api, AShutterWhoseCameraFailsIsNotKept)
{
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(test::torus())}});
    const auto pose = [&](double tau) { scene.set_transform(node, test::moved(tau, 0, 0)); };
    const auto nowhere = [] {
        Camera camera;
        camera.world_from_camera[3].x = std::numeric_limits<double>::quiet_NaN();
        return camera;
    };
    for (const int segments : {0, 4}) {
        EXPECT_THROW(record_shutter(scene, pose, nowhere, 100, segments), Error);
        EXPECT_EQ(scene.shutter_segments(), 0);
    }
}

TEST(Query, RaysOfAKindPassWhatThisKindDoesNotSee)
{
    Scene scene;
    NodeDesc desc;
    desc.cages = {scene.add(test::textured_square())};
    desc.seen_by = RayKind::Shadow;
    scene.add_node(scene.root(), desc);
    const Query query(scene, Camera::look_at({0, 0, 3}, Vec3d(0), {0, 1, 0}, 0.6f), 16);
    QueryRay ray;
    ray.origin = {0.1, 0.1, 3};
    EXPECT_FALSE(query.closest(ray)) << "the camera does not see it";
    EXPECT_FALSE(query.is_occluded(ray));
    EXPECT_FALSE(query.is_occluded({0.1, 0.1, 3}, {0.1, 0.1, -3}));
    ray.kinds = RayKind::Shadow | RayKind::Diffuse;
    EXPECT_TRUE(query.closest(ray));
    EXPECT_TRUE(query.is_occluded(ray));
    ray.kinds = 0;
    EXPECT_THROW(query.closest(ray), Error);
}

TEST(Api, FramingRefusesAnAspectThatIsNone)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(test::torus())}});
    for (const float aspect : {0.0f, -1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
        EXPECT_THROW(framing(scene, aspect), Error) << aspect;
}

// Slots of removed nodes are used again, which says nothing about the order of addition.
TEST(Api, TheFirstCameraIsTheOneThatWasAddedFirst)
{
    Scene scene;
    const NodeId first = scene.add_node(scene.root(), {}), second = scene.add_node(scene.root(), {});
    scene.remove(first);
    scene.remove(second);
    const CameraId lens = scene.add(CameraLens{});
    scene.add_node(scene.root(), {.name = "one", .camera = lens});
    scene.add_node(scene.root(), {.name = "two", .camera = lens});
    const NodeId three = scene.add_node(scene.root(), {.name = "one", .camera = lens});
    EXPECT_EQ(scene.camera_names(), (std::vector<std::string>{"one", "two", "one"}));
    EXPECT_NE(scene.find_node("one"), three);
}

}  // namespace
}  // namespace occam
