// Tests that no function of the interface depends on how the application's threads round.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "occam/occam.h"
#include "tests/support/other_floats.h"

namespace occam {
namespace {

double distance_of(const std::optional<Hit>& hit) { return hit ? hit->distance : std::numeric_limits<double>::infinity(); }

struct Question {
    QueryRay ray;
    Vec3d end;
    double x, y;
};

// The questions are made before the rounding is another one, which would change them.
std::vector<Question> questions(const Camera& camera)
{
    std::vector<Question> all;
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> random(-0.3, 0.3);
    for (int i = 0; i < 200; ++i) {
        const double x = random(generator), y = random(generator);
        const Vec3d direction{x, y - 0.2, -1};
        all.push_back({{camera.eye(), direction}, camera.eye() + 3.0 * direction, 32 + 50 * x, 24 + 50 * y});
    }
    return all;
}

std::vector<double> answers(const Query& query, const std::vector<Question>& asked)
{
    std::vector<double> all;
    std::vector<QueryRay> rays;
    for (const auto& [ray, end, x, y] : asked) {
        rays.push_back(ray);
        const std::optional<Hit> hit = query.closest(ray);
        all.push_back(distance_of(hit));
        if (hit) {
            all.insert(all.end(), {hit->position.x, hit->position.y, hit->position.z, double(hit->normal.x)});
            all.push_back(query.is_occluded(ray.origin, hit->position));  // rounding decides where the end is
            all.push_back(query.is_occluded({ray.origin, ray.direction, hit->distance}));
        }
        all.push_back(query.is_occluded(ray.origin, end));
        all.push_back(distance_of(query.closest(ray.origin, ray.direction, 20)));
        all.push_back(distance_of(query.pick(x, y, 64)));
    }
    std::vector<FirstHit> hits(rays.size());
    query.first_hits(rays, hits);
    for (const FirstHit& hit : hits) all.push_back(hit.distance);
    return all;
}

TEST(Rounding, OfTheCallerChangesNoAnswerOfAQuery)
{
    Scene scene = builtin_scene();
    const Camera camera = scene.camera().value();
    const std::vector<Question> asked = questions(camera);
    Query query(scene, camera, 48);
    const std::vector<double> expected = answers(query, asked);
    {
        const test::OtherFloats others;
        EXPECT_TRUE(answers(query, asked) == expected);
        query.begin(camera);
    }
    EXPECT_TRUE(answers(query, asked) == expected) << "begun by a thread that rounds otherwise";
}

TEST(Rounding, OfTheCallerChangesNoCamera)
{
    Scene scene = builtin_scene();
    const NodeId dolly = scene.add_node(scene.root(), {.name = "dolly", .camera = scene.add(CameraLens{.fov = 0.7f})});
    const auto fly = [&](double tau) {
        scene.set_transform(dolly, Camera::look_at({5 * tau, 1.1, 7}, {0, 0.7, 0}, {0, 1, 0}, 0.7f).world_from_camera);
    };
    const auto now = [&] { return scene.camera("dolly").value(); };
    const Mat4d expected = framing(scene).world_from_camera;
    const std::vector<Mat4d> path = record_shutter(scene, fly, now, 720).keys;
    ASSERT_FALSE(path.empty());
    scene.clear_shutter();
    const test::OtherFloats others;
    EXPECT_EQ(framing(scene).world_from_camera, expected);
    EXPECT_EQ(record_shutter(scene, fly, now, 720).keys, path);
}

TEST(Rounding, OfTheCallerChangesNoFigureOfARenderer)
{
    Scene scene = builtin_scene();
    Renderer renderer({.threads = 2});
    const std::size_t floor = renderer.memory_floor(scene);
    const std::uint64_t halvings = renderer.halvings(scene);
    const test::OtherFloats others;
    EXPECT_EQ(renderer.memory_floor(scene), floor);
    EXPECT_EQ(renderer.halvings(scene), halvings);
}

}  // namespace
}  // namespace occam
