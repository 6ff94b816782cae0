// Tests that a renderer that has seen all frames before shows the scene as a new one does, and that a query which lives
// through the edits answers as a new one does, whatever was edited in between.
//
// OCCAM_SEED=n tests that seed alone. With OCCAM_LONG=1 seeds follow one another for a third of OCCAM_CAMPAIGN_SECONDS (ten
// minutes).
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <span>

#include "tests/support/campaign.h"
#include "tests/support/case_random.h"
#include "tests/support/random_world.h"

namespace occam::test {
namespace {

constexpr std::size_t kMemory = std::size_t(1) << 30;

/// Returns rays from around the camera's place to places among the objects.
std::vector<QueryRay> rays_of(std::uint64_t seed, Vec3d eye)
{
    CaseRandom random(seed, 0, 400);
    std::vector<QueryRay> rays;
    for (int k = 0; k < 40; ++k) {
        QueryRay ray;
        ray.origin = eye + random.inside_cube();
        ray.direction = random.inside_cube() * 2.0 - ray.origin;
        ray.time = float(random.number());
        if (k % 4 == 0) ray.footprint = RayFootprint{0, float(random.between(1e-4, 0.1))};
        if (k % 5 == 0) ray.far = 6;
        rays.push_back(ray);
    }
    return rays;
}

void expect_same(const Hit& a, const Hit& b)
{
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.normal_geometric, b.normal_geometric);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.uv, b.uv);
    EXPECT_EQ(a.velocity, b.velocity);
    EXPECT_EQ(a.node.slot, b.node.slot);  // generations differ between scenes
    EXPECT_EQ(a.face, b.face);
}

/// Expects the same answers of two queries, and that the three ways to ask agree.
/// hits   is raised by the number of rays that hit something
void expect_same_answers(const Query& one, const Query& other, std::span<const QueryRay> rays, int& hits)
{
    std::vector<FirstHit> first(rays.size());
    one.first_hits(rays, first);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        SCOPED_TRACE("ray " + std::to_string(k));
        const std::optional<Hit> a = one.closest(rays[k]), b = other.closest(rays[k]);
        ASSERT_EQ(a.has_value(), b.has_value());
        EXPECT_EQ(one.is_occluded(rays[k]), a.has_value());
        EXPECT_EQ(first[k].distance < std::numeric_limits<double>::infinity(), a.has_value());
        if (!a) continue;
        ++hits;
        expect_same(*a, *b);
        EXPECT_TRUE(first[k].distance == a->distance && first[k].node == a->node && first[k].face == a->face);
    }
}

/// Edits a scene and renders it in turns. After each frame the same edits are made in a new scene that was never rendered.
void expect_frames_of_new_scenes(std::uint64_t seed, int frames)
{
    RandomWorld world(seed);
    Renderer renderer({.threads = 2, .memory_bytes = kMemory});
    Query query(renderer, world.scene(), world.camera(), 32);
    query.end();
    std::vector<const char*> edits;
    int hits = 0;
    for (int frame = 0; frame < frames && !testing::Test::HasFailure(); ++frame) {
        for (int k = 0; k <= frame % 3; ++k) edits.push_back(world.edit());
        RandomWorld other(seed);
        for (std::size_t k = 0; k < edits.size(); ++k) ASSERT_STREQ(other.edit(), edits[k]);
        std::string history;
        for (const char* edit : edits) history += std::string("; ") + edit;
        SCOPED_TRACE("OCCAM_SEED=" + std::to_string(seed) + ", frame " + std::to_string(frame) + history);
        const auto checksum = [](RandomWorld& of, Renderer& by) -> std::optional<std::uint64_t> {
            try {
                const Camera camera = of.camera();
                return by.render(of.scene(), camera, of.settings()).checksum();
            } catch (const Error& error) {
                ADD_FAILURE() << error.what();
                return {};
            }
        };
        Renderer fresh({.threads = 1, .memory_bytes = kMemory});
        EXPECT_EQ(checksum(world, renderer), checksum(other, fresh));
        const Camera camera = world.camera();
        query.begin(camera);
        const Query fresh_query(fresh, other.scene(), other.camera(), 32);
        const Vec3d eye(camera.world_from_camera[3]);
        expect_same_answers(query, fresh_query, rays_of(seed + std::uint64_t(frame), eye), hits);
        query.end();
    }
    EXPECT_GT(hits, frames) << "OCCAM_SEED=" << seed;
}

TEST(RandomEdits, ShowWhatANewRendererShowsOfANewScene)
{
    if (const char* seed = std::getenv("OCCAM_SEED"))
        return expect_frames_of_new_scenes(std::strtoull(seed, nullptr, 10), 30);
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(number_from("OCCAM_CAMPAIGN_SECONDS", 600)) / 3;
    std::uint64_t seed = 1;
    constexpr std::uint64_t kLargest = 4;  // its frames take seconds each
    for (; (is_long() ? Clock::now() < end : seed <= 6) && !HasFailure(); ++seed)
        if (is_long() || seed != kLargest) expect_frames_of_new_scenes(seed, is_long() ? 30 : 10);
    if (is_long()) std::cout << "tested seeds 1 to " << seed - 1 << '\n';
}

}  // namespace
}  // namespace occam::test
