// Tests of what a tracer promises: the same hits for single rays and packets, exact distances on gap triangles, laziness,
// any budget.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>

#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

// Adds prisms side by side with two sets of coordinates: their materials have maps on one of the sets, or none.
void add_wall_of_maps(Scene& scene)
{
    std::vector<MaterialId> materials;
    const TextureId texture = scene.add(waves(0));
    for (int k = 0; k < 4; ++k) {
        Material m;
        if (k > 0) m.normal_texture = {texture, (k - 1) & 1};
        if (k >= 2) m.bump_texture = {texture, 1};
        materials.push_back(scene.add(std::move(m)));
    }
    Cage cage = prism(5);
    cage.uv_sets.resize(2);
    for (std::size_t s = 0; s < 2; ++s)
        for (const Vec3f p : cage.positions)
            cage.uv_sets[s].values.push_back(s == 0 ? Vec2f(p.x + p.z, p.y) : Vec2f(p.y, p.x - p.z));
    for (std::size_t f = 0; f < cage.face_sizes.size(); ++f)
        cage.face_slots.push_back(static_cast<std::uint32_t>(f % materials.size()));
    cage.materials = materials;
    const CageId id = scene.add(std::move(cage));
    for (int k = 0; k < 9; ++k) place(scene, id, {-1.5 + 0.7 * (k % 3), -1, 0.7 * (k / 3)}, 0.4);
}

TEST(Tracer, FindsTheSameBitsForARayAloneAndInAPacket)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    place(stage.scene, stage.scene.add(prism(7)), {1, 0.5, -1}, 0.7);
    add_wall_of_maps(stage.scene);
    for (const int level : {-1, -4, -6}) {
        const accel::Frame frame = stage.frame(level);
        const auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 20'000, 7);
        std::vector<accel::SurfaceHit> together(rays.size()), alone(rays.size());
        accel::Tracer a(frame, kPlenty), b(frame, kPlenty);
        a.closest(rays, together);
        for (std::size_t i = 0; i < rays.size(); ++i) b.closest({&rays[i], 1}, {&alone[i], 1});
        int hits = 0, tangents = 0, bumps = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_TRUE(same(together[i], alone[i]))
                << "ray " << i << " level " << level << ": " << together[i].t << " and " << alone[i].t;
            if (!together[i].is_hit()) continue;
            ++hits;
            const bool has_tangent = together[i].tangent != Vec3f(0);
            ASSERT_TRUE(!has_tangent || together[i].material->normal_texture);
            tangents += has_tangent;
            bumps += together[i].u_gradient != Vec3f(0);
        }
        EXPECT_GT(hits, 5000);
        EXPECT_GT(tangents, 200);
        EXPECT_GT(bumps, 50);
        EXPECT_EQ(a.counters().packets > 0, kLanes > 1);
    }
}

/// Where a ray sees levels of a cage, a hit of a mesh has the level that the ray sees there. Some rays of a packet see the
/// cage, and others pass it by.
TEST(Tracer, FindsTheSameStartLevelsOnAMeshForARayAloneAndInAPacket)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    Cage floor;
    floor.scheme = Scheme::Triangles;
    floor.positions = {{-4, -0.1f, -4}, {-4, -0.1f, 4}, {4, -0.1f, 4}, {4, -0.1f, -4}};
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    place(stage.scene, stage.scene.add(floor), {0, 0, 0});
    const accel::Frame frame = stage.frame(-6);
    auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 20'000, 7);
    std::mt19937_64 random(3);
    for (accel::Ray& ray : rays) {
        ray.footprint = {0x1p-8f, std::ldexp(1.0f, -static_cast<int>(random() % 8))};
        if (random() & 1) ray.start_level = static_cast<std::int8_t>(-static_cast<int>(random() % 4));
    }
    std::vector<accel::SurfaceHit> together(rays.size()), alone(rays.size());
    accel::Tracer a(frame, kPlenty), b(frame, kPlenty);
    a.closest(rays, together);
    std::set<int> levels;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        b.closest({&rays[i], 1}, {&alone[i], 1});
        ASSERT_TRUE(same(together[i], alone[i])) << "ray " << i;
        if (together[i].is_hit()) levels.insert(together[i].start_level);
    }
    EXPECT_GT(levels.size(), 4u);
}

// Adds a mesh of horizontal squares, one close above the other.
void add_stack(Scene& scene, int sheets)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (int i = 0; i < sheets; ++i) {
        const auto first = static_cast<std::uint32_t>(cage.positions.size());
        const float y = -1 + 2 * float(i) / float(sheets);
        for (const Vec2f c : {Vec2f(-2, -2), Vec2f(-2, 2), Vec2f(2, 2), Vec2f(2, -2)})
            cage.positions.push_back({c.x, y, c.y});
        for (const std::uint32_t v : {0, 1, 2, 0, 2, 3}) cage.face_vertices.push_back(first + v);
    }
    place(scene, scene.add(std::move(cage)), {0, 0, 0});
}

TEST(Tracer, FindsSeveralHitsAtOnceAsOneAfterTheOther)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    add_wall_of_maps(stage.scene);
    add_stack(stage.scene, 150);
    const accel::Frame frame = stage.frame(-4);
    const auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 300, 11);
    for (const std::size_t memory_bytes : {kPlenty, std::size_t(600) << 10})
        for (const int most : {1, 5, accel::kMostNearest}) {
            accel::Tracer at_once(frame, memory_bytes), one_by_one(frame, kPlenty);
            std::vector<accel::SurfaceHit> hits(rays.size() * std::size_t(most));
            std::vector<accel::HitCount> counts(rays.size());
            at_once.nearest(rays, most, hits, counts);
            int whole = 0, parts = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                accel::Ray ray = rays[i];
                accel::SurfaceHit hit;
                for (int k = 0; k < counts[i].count; ++k) {
                    one_by_one.closest({&ray, 1}, {&hit, 1});
                    ASSERT_TRUE(hit.is_hit() && same(hits[i * std::size_t(most) + std::size_t(k)], hit)) << i << ' ' << k;
                    ray.t_near = accel::behind(hit.t);
                }
                if (!counts[i].is_all) {
                    ASSERT_GT(counts[i].count, 0);
                    ++parts;
                    continue;
                }
                ++whole;
                one_by_one.closest({&ray, 1}, {&hit, 1});
                ASSERT_FALSE(hit.is_hit()) << i;
            }
            EXPECT_GT(parts, 50) << most;
            if (most == accel::kMostNearest) {
                EXPECT_GT(whole, 10);
            }
        }
}

TEST(Tracer, FindsNothingWhereARayEnds)
{
    Stage stage;
    add_stack(stage.scene, 20);
    const accel::Frame frame = stage.frame(-4);
    accel::Tracer tracer(frame, kPlenty);
    int tested = 0;
    for (accel::Ray ray : rays_towards({0.3, 3, 4}, stage.scene.bounds(), 300, 11)) {
        accel::SurfaceHit first, hit, several[4];
        tracer.closest({&ray, 1}, {&first, 1});
        if (!first.is_hit()) continue;
        ray.t_far = first.t;
        accel::HitCount count;
        std::uint8_t is_occluded = 2;
        tracer.closest({&ray, 1}, {&hit, 1});
        tracer.nearest({&ray, 1}, 4, several, {&count, 1});
        tracer.occluded({&ray, 1}, {&is_occluded, 1});
        EXPECT_FALSE(hit.is_hit());
        EXPECT_TRUE(count.count == 0 && count.is_all) << count.count;
        EXPECT_EQ(is_occluded, 0);
        ++tested;
    }
    EXPECT_GT(tested, 100);
}

TEST(Tracer, FindsTheSameFirstHitsWithoutWhatShadingNeeds)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    place(stage.scene, stage.scene.add(prism(7)), {1, 0.5, -1}, 0.7);
    const accel::Frame frame = stage.frame(-4);
    const auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 20'000, 11);
    std::vector<accel::SurfaceHit> whole(rays.size());
    std::vector<accel::FirstHit> first(rays.size());
    accel::Tracer(frame, kPlenty).closest(rays, whole);
    accel::Tracer(frame, kPlenty).first_hits(rays, first);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(first[i].t, whole[i].t) << "ray " << i;
        ASSERT_EQ(first[i].is_hit(), whole[i].is_hit());
        if (!whole[i].is_hit()) continue;
        ASSERT_EQ(first[i].face, whole[i].face) << "ray " << i;
        ASSERT_EQ(first[i].node, whole[i].node) << "ray " << i;
    }
}

// Trees may be eager or lazy, flat or by hierarchy, swept or scanned. The trees differ, but the hits are the same.
TEST(Tracer, FindsTheSameHitsHoweverItBuilds)
{
    Stage stage;
    const CageId ring = stage.scene.add(torus(24, 12));
    for (int i = 0; i < 9; ++i) place(stage.scene, ring, {i % 3 * 2.0 - 2, 0.1 * i, i / 3 * 2.0 - 2}, 0.7);
    place(stage.scene, stage.scene.add(prism(7)), {0, 1, 0});
    const accel::Frame frame = stage.frame(-5);
    const auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 4000, 7);
    std::vector<accel::SurfaceHit> usual(rays.size()), hits(rays.size());
    accel::Tracer(frame, kPlenty).closest(rays, usual);
    std::array<std::uint64_t, 8> nodes{};
    for (int on = 0; on < 8; ++on) {
        accel::Tracer tracer(frame, kPlenty, {(on & 1) != 0, (on & 2) != 0, (on & 4) != 0});
        EXPECT_EQ(tracer.counters().kd_nodes > 0, (on & 1) == 0) << "built before the first ray, unless lazily";
        tracer.closest(rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i)
            ASSERT_TRUE(same(usual[i], hits[i])) << "ray " << i << " techniques " << on;
        nodes[std::size_t(on)] = tracer.counters().kd_nodes;
    }
    for (std::size_t on = 0; on < 8; ++on) {
        EXPECT_NE(nodes[on], nodes[on ^ 1]) << "lazily, techniques " << on;
        EXPECT_NE(nodes[on], nodes[on ^ 2]) << "by hierarchy, techniques " << on;
        if ((on & 2) == 0) {
            EXPECT_NE(nodes[on], nodes[on ^ 4]) << "swept, techniques " << on;
        }
    }
}

TEST(Tracer, AnswersOcclusionAsTheNearestHitDoes)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    const accel::Frame frame = stage.frame(-4);
    auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 20'000, 8);
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i].t_far = 3.5f + float(i % 100) * 0.03f;
    std::vector<accel::SurfaceHit> hits(rays.size());
    std::vector<std::uint8_t> occluded(rays.size());
    accel::Tracer tracer(frame, kPlenty);
    tracer.closest(rays, hits);
    tracer.occluded(rays, occluded);
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_EQ(hits[i].is_hit(), occluded[i] != 0) << "ray " << i;
}

TEST(Tracer, GivesTheSameHitsForAnyBudget)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    place(stage.scene, stage.scene.add(prism(5)), {1, 0.5, -1}, 0.7);
    const accel::Frame frame = stage.frame(-6);
    const auto rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), is_long() ? 4'000 : 1'000, 9);
    std::vector<accel::SurfaceHit> expected(rays.size()), hits(rays.size());
    accel::Tracer whole(frame, kPlenty);
    whole.closest(rays, expected);
    EXPECT_EQ(whole.counters().flushes, 0u);
    const std::size_t used = whole.counters().peak_bytes;
    for (const std::size_t memory_bytes : {used / 2, used / 4, used / 16, std::size_t(1)}) {
        accel::Tracer tracer(frame, memory_bytes);
        tracer.closest(rays, hits);
        EXPECT_GT(tracer.counters().flushes, 0u);
        for (std::size_t i = 0; i < rays.size(); ++i)
            ASSERT_TRUE(same(expected[i], hits[i])) << "ray " << i << " budget " << memory_bytes;
        if (memory_bytes < used / 8) continue;  // this is less than one packet needs
        EXPECT_LE(tracer.counters().peak_bytes, memory_bytes + Arena::kChunkBytes)
            << "the budget is kept to within what one step builds";
    }
}

// Rays aimed at T-vertices hit gap triangles, where in float their t is noise along the edge (watertightness, rule 6).
TEST(Tracer, ReportsTheExactDistanceOnClosingTriangles)
{
    const Cage cage = torus();
    DicedCage diced(cage, 0);
    diced.level_of_largest_exponent(5);  // at 4 there are 80 T-vertices, and the test needs more than 100
    std::vector<Vec3d> middles;
    for (const MeshTriangle& t : diced.triangles())
        if (t.is_gap) middles.push_back(Vec3d(t.v[1]) + diced.posed.anchor);
    ASSERT_GT(middles.size(), 100u);

    Stage stage;
    place(stage.scene, stage.scene.add(cage), {0, 0, 0});
    const accel::Frame frame = stage.frame(diced.posed.level, lod::LevelMode::PerInstance);
    accel::Tracer tracer(frame, kPlenty);
    const Vec3d eye{0.2, 5, 0.4};
    for (const Vec3d middle : middles) {
        accel::Ray ray;
        ray.origin = eye;
        ray.direction = Vec3f(glm::normalize(middle - eye));
        accel::SurfaceHit hit;
        tracer.closest({&ray, 1}, {&hit, 1});
        ASSERT_TRUE(hit.is_hit());
        const double distance = glm::distance(middle, eye);
        if (hit.t < distance - 0.05) continue;  // something lies in front
        // A ray misses its target by the rounding of its direction, which a slope of 1:50 makes 50 times longer.
        EXPECT_NEAR(hit.t, distance, 50 * distance * 1.2e-7);
    }
}

TEST(Tracer, BuildsLittleMoreThanItsRaysSee)
{
    Stage stage;
    const CageId cage = stage.scene.add(torus(16, 8));
    const int side = is_long() ? 20 : 10;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) place(stage.scene, cage, {4.0 * i, 0, 4.0 * j});
    const accel::Frame frame = stage.frame(-4);
    // This ray sees all of it, from above.
    accel::Tracer all(frame, kPlenty);
    const double middle = 2.0 * side;
    const auto everywhere = rays_towards({middle, 200, middle}, stage.scene.bounds(), 500 * side * side, 3);
    std::vector<accel::SurfaceHit> hits(everywhere.size());
    all.closest(everywhere, hits);
    // These rays see four of all.
    accel::Tracer some(frame, kPlenty);
    const Box3d corner{{-1.5, -0.5, -1.5}, {5.5, 0.5, 5.5}};
    const auto few = rays_towards({2, 20, 2}, corner, 20'000, 4);
    hits.resize(few.size());
    some.closest(few, hits);
    const double share = 4.0 / (side * side);
    EXPECT_LE(double(some.counters().micropolygons), 2 * share * double(all.counters().micropolygons));
    EXPECT_LE(double(some.counters().faces_touched), 2 * share * double(all.counters().faces_touched));
    EXPECT_LE(double(some.counters().kd_nodes), 4 * share * double(all.counters().kd_nodes));
}

TEST(Tracer, CountsWhatCameraRaysAreTheFirstToAskForHoweverTheyAsk)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    const accel::Frame frame = stage.frame(-4);
    std::vector<accel::Ray> rays = rays_towards({0.3, 3, 4}, stage.scene.bounds(), 100, 11);
    for (const bool are_of_camera : {true, false}) {
        for (accel::Ray& ray : rays) ray.kinds = are_of_camera ? accel::RayKind::Camera : accel::RayKind::Diffuse;
        accel::Tracer together(frame, kPlenty), observed(frame, kPlenty);
        std::vector<accel::SurfaceHit> hits(rays.size() * 2);
        std::vector<accel::HitCount> counts(rays.size());
        together.nearest(rays, 2, hits, counts);
        for (const accel::Ray& ray : rays) observed.observe(ray, hits[0]);
        for (const accel::Tracer* tracer : {&together, &observed}) {
            const accel::TraceCounters counters = tracer->counters();
            EXPECT_GT(counters.diced, 0u);
            EXPECT_EQ(counters.diced_for_camera, are_of_camera ? counters.diced : 0);
            EXPECT_EQ(counters.diced_for_occlusion, 0u);
        }
    }
}

TEST(Tracer, MeetsNothingInAnEmptySceneAndWithRaysOfNoDirection)
{
    Stage empty;
    const accel::Frame nothing = empty.frame(0);
    accel::Tracer tracer(nothing, kPlenty);
    accel::Ray ray;
    accel::SurfaceHit hit;
    tracer.closest({&ray, 1}, {&hit, 1});
    EXPECT_FALSE(hit.is_hit());

    Stage stage;
    place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    const accel::Frame frame = stage.frame(-3);
    accel::Tracer other(frame, kPlenty);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Vec3f d : {Vec3f(0), Vec3f(nan), Vec3f(nan, 0, 1), Vec3f(std::numeric_limits<float>::infinity(), 0, 0)}) {
        ray.direction = d;
        other.closest({&ray, 1}, {&hit, 1});
        EXPECT_FALSE(hit.is_hit());
    }
    ray.direction = {0, 0, -1};
    ray.origin = Vec3d(std::numeric_limits<double>::quiet_NaN());
    other.closest({&ray, 1}, {&hit, 1});
    EXPECT_FALSE(hit.is_hit());
}

}  // namespace
}  // namespace occam::test
