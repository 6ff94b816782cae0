// Tests of what a tracer promises for a scene that moves: the hits of each ray are those of the scene at the ray's own time,
// with the same bits alone and in company and for any budget.
#include <gtest/gtest.h>

#include <bit>
#include <tuple>

#include "accel/frame.h"
#include "accel/items.h"
#include "accel/memory_floor.h"
#include "accel/tracer.h"
#include "tests/support/campaign.h"
#include "tests/support/motions.h"
#include "tests/support/random_directions.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr std::size_t kPlenty = std::size_t(1) << 30;

lod::LevelSettings exact(int level, lod::LevelMode mode)
{
    return {.pixel = {std::ldexp(1.0f, level), 0}, .mode = mode, .motion_edges = 0};
}

bool same(const accel::SurfaceHit& a, const accel::SurfaceHit& b)
{
    if (std::bit_cast<std::uint32_t>(a.t) != std::bit_cast<std::uint32_t>(b.t)) return false;
    const auto all = [](const accel::SurfaceHit& h) {
        return std::tuple(h.self_distance, h.normal_geometric, h.curvature, h.normal_shading, h.blend, h.position, h.node,
                          h.face, h.back_side, h.level, h.micropolygon, h.to_start, h.start_normal, h.start_level,
                          h.velocity);
    };
    return !a.is_hit() || all(a) == all(b);
}

accel::Ray ray_down(Vec3d origin, float time)
{
    accel::Ray ray;
    ray.origin = origin;
    ray.direction = {0, -1, 0};
    ray.time = time;
    return ray;
}

// Rays towards a scene in which much moves and something stands, with a footprint that spans several levels.
std::vector<accel::Ray> rays_at_any_time(const Box3d& bounds, int count, Random& random)
{
    std::vector<accel::Ray> rays(static_cast<std::size_t>(count));
    for (accel::Ray& ray : rays) {
        ray.origin = {0.3, 5, 6};
        const Vec3d to = bounds.lo + bounds.extent() * Vec3d(random(), random(), random());
        ray.direction = Vec3f(glm::normalize(to - ray.origin));
        ray.footprint = {0.01f, 0.02f};
        // Some are exactly at a key.
        ray.time = random() < 0.1 ? static_cast<float>(std::floor(random() * 9) / 8) : static_cast<float>(random());
    }
    return rays;
}

// A torus that turns, one that bends, a mesh that flies, and a prism that stands.
struct MovingStage {
    Scene scene;
    lod::TopologyCache topologies;
    std::vector<NodeId> nodes;

    explicit MovingStage(int segments = 8)
    {
        const CageId ring = scene.add(torus()), bent = scene.add(torus(7, 5));
        Cage mesh;
        mesh.scheme = Scheme::Triangles;
        const Cage cube = creased_cube(0);
        mesh.positions = cube.positions;
        for (std::size_t f = 0; f < 6; ++f)
            for (const std::size_t k : {0, 1, 2, 0, 2, 3}) mesh.face_vertices.push_back(cube.face_vertices[4 * f + k]);
        nodes = {place(scene, ring, {-1.5, 0, 0}), place(scene, bent, {1.5, 0, 0}),
                 place(scene, scene.add(std::move(mesh)), {0, 0, -2}, 0.5),
                 place(scene, scene.add(prism(7)), {0, -1, 1}, 0.7)};
        const std::vector<Vec3f> rest = scene.cage(bent).cage.positions;
        scene.record_shutter(segments, [&](double tau) {
            Trs turning;
            turning.translation = {-1.5, 0, 0};
            turning.rotation = {std::sin(tau), 0, 0, std::cos(tau)};
            scene.set_transform(nodes[0], turning);
            std::vector<Vec3f> moved = rest;
            for (Vec3f& p : moved) p.y += static_cast<float>(tau) * p.x * p.x;
            scene.write_vertices(bent, moved);
            Trs flying;
            flying.translation = {3 * tau, tau, -2};
            flying.scale = Vec3d(0.5);
            scene.set_transform(nodes[2], flying);
        });
        scene.refit();
    }
};

TEST(MovingTracer, FindsTheSameBitsForARayAloneAndInAPacket)
{
    for (const int segments : {1, 8}) {
        MovingStage stage(segments);
        const accel::Frame frame(stage.scene, stage.topologies, exact(-5, lod::LevelMode::PerRay));
        Random random(3);
        const auto rays = rays_at_any_time(stage.scene.bounds(), 10'000, random);
        std::vector<accel::SurfaceHit> together(rays.size()), alone(rays.size());
        accel::Tracer a(frame, kPlenty), b(frame, kPlenty);
        a.closest(rays, together);
        std::vector<std::uint8_t> occluded(rays.size());
        a.occluded(rays, occluded);
        std::array<int, 4> hits{};
        for (std::size_t i = 0; i < rays.size(); ++i) {
            b.closest({&rays[i], 1}, {&alone[i], 1});
            ASSERT_TRUE(same(together[i], alone[i]))
                << "ray " << i << " at " << rays[i].time << ": " << together[i].t << " and " << alone[i].t;
            ASSERT_EQ(occluded[i] != 0, together[i].is_hit());
            for (std::size_t n = 0; n < 4; ++n) hits[n] += together[i].is_hit() && together[i].node == stage.nodes[n];
            const bool is_still = together[i].is_hit() && together[i].node == stage.nodes[3];
            ASSERT_TRUE(!is_still || together[i].velocity == Vec3f(0));
        }
        for (const int n : hits) EXPECT_GT(n, 100);
    }
}

TEST(MovingTracer, FindsTheSameHitsForAnyBudgetAndInASharedTree)
{
    MovingStage stage;
    const accel::Frame frame(stage.scene, stage.topologies, exact(-7, lod::LevelMode::PerRay));
    Random random(5);
    auto rays = rays_at_any_time(stage.scene.bounds(), 4000, random);
    for (accel::Ray& ray : rays) ray.footprint = {0.002f, 0.002f};
    std::vector<accel::SurfaceHit> usual(rays.size()), hits(rays.size());
    accel::Tracer tracer(frame, kPlenty);
    tracer.closest(rays, usual);
    const std::size_t floor = accel::memory_floor(stage.scene);
    accel::Tracer small(frame, floor);
    small.closest(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(same(usual[i], hits[i])) << i;
    EXPECT_GT(tracer.counters().peak_bytes, floor);
    EXPECT_GT(small.counters().flushes, 0u);
    accel::SharedTree tree(frame, kPlenty);
    accel::Tracer(tree).closest(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(same(usual[i], hits[i])) << i;
}

struct PlainHit {
    double t, least_share, cosine;
};

// Every triangle that the ray's line meets, or nearly so.
std::vector<PlainHit> all_hits(const std::vector<Vec3d>& corners, Vec3d origin, Vec3d direction)
{
    std::vector<PlainHit> hits;
    for (std::size_t k = 0; k < corners.size(); k += 3) {
        const Vec3d a = corners[k] - origin, e = corners[k + 1] - corners[k], f = corners[k + 2] - corners[k];
        const Vec3d n = glm::cross(e, f);
        const double det = glm::dot(n, direction);
        if (det == 0) continue;
        const double t = glm::dot(n, a) / det;
        const Vec3d p = direction * t - a;
        const double square = glm::dot(n, n), v = glm::dot(glm::cross(p, f), n) / square,
                     w = glm::dot(glm::cross(e, p), n) / square;
        const double least = std::min({v, w, 1 - v - w});
        if (t > 0 && least > -1e-3) hits.push_back({t, least, std::abs(det) / std::sqrt(square)});
    }
    return hits;
}

// Compares a tracer with all triangles, interpolated in double, at a few moments with many rays each.
void expect_hits_of_all_triangles(const Cage& cage, const Motion& motion, int level)
{
    Scene scene;
    const NodeId node = add_moving(scene, cage, motion);
    scene.refit();
    const DicedMotion diced(scene, node, level);
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, exact(level, lod::LevelMode::PerInstance));
    accel::Tracer tracer(frame, kPlenty);
    Random random(11);
    const int moments = is_long() ? 700 : 12, rays_of_each = is_long() ? 700 : 64;
    std::vector<accel::Ray> rays;
    std::vector<std::vector<Vec3d>> corners;
    for (int m = 0; m < moments; ++m) {
        const auto time = m == 0 ? 0.0f : m == 1 ? 1.0f : static_cast<float>(random());
        corners.push_back(diced.corners_at(double(time)));
        Box3d box;
        for (const Vec3d p : corners.back()) box.add(p);
        for (int r = 0; r < rays_of_each; ++r) {
            accel::Ray ray;
            ray.time = time;
            ray.origin = box.centre() + random.direction() * (2.0 + 2 * random());
            const Vec3d to = box.lo + box.extent() * Vec3d(random(), random(), random());
            ray.direction = Vec3f(glm::normalize(to - ray.origin));
            rays.push_back(ray);
        }
    }
    // Rays of different moments travel together.
    std::vector<std::size_t> order(rays.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i % std::size_t(moments) * std::size_t(rays_of_each) + i / std::size_t(moments);
    std::vector<accel::Ray> mixed;
    for (const std::size_t i : order) mixed.push_back(rays[i]);
    std::vector<accel::SurfaceHit> hits(rays.size());
    tracer.closest(mixed, hits);
    int met = 0;
    for (std::size_t i = 0; i < mixed.size(); ++i) {
        const accel::Ray& ray = mixed[i];
        const auto all = all_hits(corners[order[i] / std::size_t(rays_of_each)], ray.origin, Vec3d(ray.direction));
        const auto near = [&](const PlainHit& h) { return 1e-5 * h.t + 2e-6 / std::max(h.cosine, 1e-6); };
        bool is_known = false;
        for (const PlainHit& h : all) {
            is_known |= hits[i].is_hit() && std::abs(double(hits[i].t) - h.t) <= near(h);
            const bool is_sure = h.least_share > 1e-3 && h.cosine > 1e-3;
            ASSERT_TRUE(!is_sure || double(hits[i].t) <= h.t + near(h)) << motion.name << " ray " << i << " at " << ray.time;
        }
        ASSERT_EQ(is_known, hits[i].is_hit()) << motion.name << " ray " << i << " at " << ray.time << ": " << hits[i].t;
        met += hits[i].is_hit();
    }
    EXPECT_GT(met, int(mixed.size()) / 20) << motion.name;
}

TEST(MovingTracer, FindsTheHitsOfAllTrianglesAtTheTimeOfEachRay)
{
    for (const Motion& motion : motions()) expect_hits_of_all_triangles(torus(), motion, -3);
}

TEST(MovingTracer, FindsTheHitsOfAllTrianglesOfAMesh)
{
    for (const Motion& motion : motions()) expect_hits_of_all_triangles(torus_mesh(20, 14), motion, 0);
}

TEST(MovingTracer, GivesTheVelocityOfTheSurface)
{
    Motion motion{"moves_and_stretches",
                  2,
                  {},
                  [](Vec3f p, double tau) { return p * Vec3f(1, 1 + float(tau), 1) + Vec3f(2, 0, 1) * float(tau); },
                  {},
                  {}};
    for (const bool is_mesh : {false, true}) {
        Cage cage = creased_cube(10);
        if (is_mesh) {
            const Cage cube = cage;
            cage = {};
            cage.scheme = Scheme::Triangles;
            cage.positions = cube.positions;
            for (std::size_t f = 0; f < 6; ++f)
                for (const std::size_t k : {0, 1, 2, 0, 2, 3}) cage.face_vertices.push_back(cube.face_vertices[4 * f + k]);
        }
        Scene scene;
        add_moving(scene, cage, motion);
        scene.refit();
        lod::TopologyCache topologies;
        const accel::Frame frame(scene, topologies, exact(-3, lod::LevelMode::PerRay));
        accel::Tracer tracer(frame, kPlenty);
        for (const float time : {0.0f, 0.25f, 0.5f, 0.8f, 1.0f}) {
            const accel::Ray ray = ray_down({0.1 + 2 * time, 5, 0.2 + time}, time);
            accel::SurfaceHit hit;
            tracer.closest({&ray, 1}, {&hit, 1});
            ASSERT_TRUE(hit.is_hit());
            EXPECT_NEAR(hit.position.y, 1 + time, 1e-4);
            EXPECT_NEAR(glm::distance(hit.velocity, Vec3f(2, 1, 1)), 0, 1e-3) << time;
            EXPECT_NEAR(hit.normal_shading.y, 1, 1e-3);
            EXPECT_FALSE(hit.back_side);
        }
    }
}

TEST(MovingTracer, SeesNodesWhereTheyAreVisible)
{
    Scene scene;
    const NodeId node = place(scene, scene.add(creased_cube(10)), {0, 0, 0}),
                 below = place(scene, scene.add(creased_cube(10)), {0, -5, 0});
    scene.record_shutter(4, [&](double tau) { scene.set_visible(node, tau == 0.25 || tau == 0.75); });
    scene.refit();
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, exact(-2, lod::LevelMode::PerRay));
    std::vector<accel::Ray> rays;
    for (int i = 0; i <= 256; ++i) rays.push_back(ray_down({0.1, 5, 0.2}, float(i) / 256));
    std::vector<accel::SurfaceHit> hits(rays.size());
    accel::Tracer tracer(frame, kPlenty);
    tracer.closest(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const int segment = std::min(static_cast<int>(rays[i].time * 4), 3);
        const bool is_seen = segment == 1 || segment == 3;
        ASSERT_EQ(hits[i].node, is_seen ? node : below) << rays[i].time;
        accel::SurfaceHit alone;
        tracer.closest({&rays[i], 1}, {&alone, 1});
        ASSERT_EQ(alone.node, hits[i].node);
    }
}

// Returns the hits of rays on a cube that is seen in the first half of the shutter, along a path that bends where it
// vanishes: the straight line between the ends of the path leaves all places at which keys see the cube. With `above`, the
// node above the cube is hidden in its place. With `roomy`, cubes below and above make the boxes around it larger.
std::vector<accel::SurfaceHit> hits_of_a_cube_that_vanishes(bool above, bool roomy, accel::TreeKind tree)
{
    Scene scene;
    const CageId cube = scene.add(creased_cube(10));
    const NodeId group = scene.add_node(scene.root(), {}), node = scene.add_node(group, {.cages = {cube}});
    for (const double y : {-4.0, 4.0})
        if (roomy) scene.add_node(group, {.place = {.translation = {0, y, 0}}, .cages = {cube}});
    scene.record_shutter(2, [&](double tau) {
        scene.set_transform(node, Trs{.translation = {0, tau > 0.5 ? 0.4 : 0, 0}});
        scene.set_visible(above ? group : node, tau == 0);
    });
    scene.refit();
    lod::TopologyCache topologies;
    const accel::Frame frame(scene, topologies, {.pixel = {1, 0}}, {.tree = tree});
    std::vector<accel::Ray> rays;
    for (int i = 0; i < 300; ++i) {
        accel::Ray& ray = rays.emplace_back();
        ray.origin = {-5, -1.5 + 0.01 * i, 0.1};
        ray.direction = {1, 0, 0};
        ray.time = float(i % 8) / 16;
    }
    std::vector<accel::SurfaceHit> hits(rays.size());
    accel::Tracer(frame, kPlenty).closest(rays, hits);
    return hits;
}

TEST(MovingTracer, FindsWhatIsHiddenForAPartOfTheTimeWhateverIsBesideIt)
{
    for (const accel::TreeKind tree : {accel::TreeKind::Bvh, accel::TreeKind::Kd})
        for (const bool above : {false, true}) {
            const auto tight = hits_of_a_cube_that_vanishes(above, false, tree),
                       roomy = hits_of_a_cube_that_vanishes(above, true, tree);
            int found = 0;
            for (std::size_t i = 0; i < tight.size(); ++i) {
                ASSERT_EQ(tight[i].is_hit(), roomy[i].is_hit()) << i << (above ? " hidden by the node above" : "");
                ASSERT_EQ(tight[i].t, roomy[i].t) << i;
                found += tight[i].is_hit();
            }
            EXPECT_NEAR(found, 200, 2);
        }
}

TEST(MovingItems, HaveBoxesAtTheKeysOfTheShutter)
{
    MovingStage stage;
    const accel::Frame frame(stage.scene, stage.topologies, exact(-5, lod::LevelMode::PerRay));
    Arena arena;
    lod::Dicer dicer;
    accel::TraceCounters counters;
    accel::Items items(frame.state(), arena, dicer, counters, true);
    items.restart();
    int moving = 0, still = 0;
    for (const accel::ItemIndex i : items.base_patches()) {
        const auto boxes = items.key_boxes(i);
        if (boxes.empty()) {
            ++still;
            continue;
        }
        ++moving;
        ASSERT_EQ(boxes.size(), 9u);
        for (const Box3f& box : boxes)
            for (int a = 0; a < 3; ++a) {
                ASSERT_GE(box.lo[a], items[i].box.lo[a]);
                ASSERT_LE(box.hi[a], items[i].box.hi[a]);
            }
    }
    EXPECT_GT(moving, 50);
    EXPECT_GT(still, 8);
}

}  // namespace
}  // namespace occam::test
