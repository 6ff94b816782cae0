// Tests that a ray meets the same bits in the tree of boxes as in the kd-tree: at all levels, in packets and alone, for any
// budget, however the tree is built, and in a tree that several tracers share.
#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "tests/support/campaign.h"
#include "tests/support/textured_floor.h"
#include "tests/support/tracer_stage.h"

namespace occam::test {
namespace {

using accel::TreeKind;

/// What all three kinds of query answer.
struct Answers {
    explicit Answers(std::size_t count) : hits(count), first(count), occluded(count) {}
    Answers(accel::Tracer& tracer, std::span<const accel::Ray> rays) : Answers(rays.size())
    {
        ask(tracer, rays, 0, rays.size());
    }
    void ask(accel::Tracer& tracer, std::span<const accel::Ray> rays, std::size_t from, std::size_t count)
    {
        tracer.closest(rays.subspan(from, count), {&hits[from], count});
        tracer.first_hits(rays.subspan(from, count), {&first[from], count});
        tracer.occluded(rays.subspan(from, count), {&occluded[from], count});
    }
    std::vector<accel::SurfaceHit> hits;
    std::vector<accel::FirstHit> first;
    std::vector<std::uint8_t> occluded;
};

void expect_same(const Answers& a, const Answers& b, const std::string& what)
{
    for (std::size_t i = 0; i < a.hits.size(); ++i) {
        ASSERT_TRUE(same(a.hits[i], b.hits[i])) << what << ", ray " << i << ": " << a.hits[i].t << ", " << b.hits[i].t;
        ASSERT_EQ(a.first[i].t, b.first[i].t) << what << ", ray " << i;
        ASSERT_EQ(a.first[i].face, b.first[i].face) << what << ", ray " << i;
        ASSERT_EQ(a.occluded[i], b.occluded[i]) << what << ", ray " << i;
    }
}

// Adds cages of many sizes, an instanced group, a cage in one place several times, and triangle meshes.
void add_all_kinds(Scene& scene)
{
    const CageId ring = scene.add(torus()), many = scene.add(torus(40, 20)), drum = scene.add(prism(7));
    place(scene, ring, {0, 0, 0});
    place(scene, many, {1.5, 0.6, -1}, 0.6);
    for (int k = 0; k < 9; ++k) place(scene, drum, {-1.5 + 0.7 * (k % 3), -1, 0.7 * (k / 3)}, std::ldexp(0.4, -k));
    for (int k = 0; k < 3; ++k) place(scene, drum, {-1, 1, 0}, 0.3);
    const CageId floor = scene.add(floor_of(scene.add(Material()), Scheme::Triangles));
    place(scene, floor, {0, -1.2, 0}, 2);
    NodeDesc turned;
    turned.place.translation = {2, 1, 1};
    turned.place.rotation = glm::normalize(Vec4d(0.2, 0.4, 0.1, 0.88));
    turned.place.scale = {0.4, 0.7, 0.3};
    NodeDesc group;
    group.cages = {ring, floor};
    group.visible = false;
    turned.instance_of = scene.add_node(scene.root(), group);
    scene.add_node(scene.root(), turned);
}

// Rays from the eye, and rays of many widths and starts from all around, some of which begin on the mesh of a level.
std::vector<accel::Ray> all_rays(const Box3d& bounds)
{
    std::vector<accel::Ray> rays = rays_towards({0.3, 3, 4}, bounds, 1200, 7),
                            other = rays_towards({0, 0, 0}, bounds, 1200, 8);
    std::mt19937 random(3);
    for (accel::Ray& ray : other) {
        for (int a = 0; a < 3; ++a) ray.origin[a] = bounds.lo[a] + bounds.extent()[a] * double(random() % 97) / 90.0;
        ray.footprint = {std::ldexp(1.0f, -int(random() % 7)), float(int(random() % 5) - 2) * 0.02f};
        if (random() % 2) ray.start_level = static_cast<std::int8_t>(-int(random() % 6));
        if (random() % 4 == 0) ray.t_far = 1.5f;
        if (random() % 8 == 0) ray.direction = {0, random() % 2 ? 1.0f : -1.0f, 0};
    }
    rays.insert(rays.end(), other.begin(), other.end());
    return rays;
}

TEST(Trees, FindTheSameBitsAtAllLevelsAndForAnyBudget)
{
    EveryNth some(2);
    for (const int level : {-1, -4})
        for (const lod::LevelMode mode : {lod::LevelMode::PerRay, lod::LevelMode::Frozen, lod::LevelMode::PerInstance}) {
            if (!some.takes()) continue;
            Stage stage;
            add_all_kinds(stage.scene);
            const accel::Frame kd = stage.frame(level, mode, TreeKind::Kd), bvh = stage.frame(level, mode, TreeKind::Bvh);
            ASSERT_EQ(kd.tree(), TreeKind::Kd);
            ASSERT_EQ(bvh.tree(), TreeKind::Bvh);
            const auto rays = all_rays(stage.scene.bounds());
            accel::Tracer in_kd(kd, kPlenty), in_bvh(bvh, kPlenty);
            const Answers expected(in_kd, rays);
            const std::string where = "mode " + std::to_string(int(mode)) + ", level " + std::to_string(level);
            expect_same(expected, Answers(in_bvh, rays), where);
            std::size_t hits = 0;
            for (const accel::SurfaceHit& hit : expected.hits) hits += hit.is_hit();
            EXPECT_GT(hits, rays.size() / 4);
            EXPECT_EQ(in_bvh.counters().flushes, 0u);
            for (const std::size_t part : {2, 8, 1'000'000}) {
                accel::Tracer tight(bvh, in_bvh.counters().peak_bytes / part);
                const std::span<const accel::Ray> first = std::span(rays).first(part > 8 ? 100 : rays.size());
                Answers answers = expected;
                answers.ask(tight, first, 0, first.size());
                expect_same(expected, answers, where + ", 1/" + std::to_string(part) + " of the memory");
                EXPECT_GT(tight.counters().flushes, 0u);
            }
        }
}

// Cages that fly apart, each its own way, one that turns, and one that stands, while the shutter is open.
void record_flights(Scene& scene, int segments, double distance)
{
    const CageId ring = scene.add(torus()), drum = scene.add(prism(5));
    std::vector<NodeId> nodes;
    for (int k = 0; k < 90; ++k)
        nodes.push_back(place(scene, k % 2 ? ring : drum, {k % 9 * 0.7 - 2.8, k / 9 * 0.6 - 2.7, -(k % 7) * 0.5}, 0.2));
    place(scene, scene.add(floor_of(scene.add(Material()), Scheme::Triangles)), {0, -3, 0}, 2);
    place(scene, ring, {0, 0, 1});
    scene.record_shutter(segments, [&](double tau) {
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const double angle = double(k * k), at = double(k);
            Trs trs;
            trs.translation = {k % 9 * 0.7 - 2.8 + distance * tau * std::cos(angle), double(k / 9) * 0.6 - 2.7,
                               -double(k % 7) * 0.5 + distance * tau * std::sin(angle)};
            trs.rotation = {0, std::sin(0.5 * at * tau), 0, std::cos(0.5 * at * tau)};
            trs.scale = Vec3d(0.2);
            scene.set_transform(nodes[k], trs);
        }
    });
}

// Observes every `step`-th ray in both trees: it finds the same hit with the same bits, what is written about it names that
// hit, and no triangle was left out that the ray hits in its interval.
void expect_observed_as_found(const accel::Frame& kd, const accel::Frame& bvh, std::span<const accel::Ray> rays,
                              std::size_t step)
{
    accel::Tracer all(bvh, kPlenty), in_kd(kd, kPlenty), in_bvh(bvh, kPlenty);
    std::vector<accel::SurfaceHit> hits(rays.size());
    all.closest(rays, hits);
    std::size_t told = 0;
    for (std::size_t i = 0; i < rays.size(); i += step)
        for (accel::Tracer* tracer : {&in_kd, &in_bvh}) {
            accel::SurfaceHit quietly, observed;
            tracer->observe(rays[i], quietly);
            std::ostringstream out;
            const accel::RayCost cost = tracer->observe(rays[i], observed, &out);
            const std::string text = out.str();
            ASSERT_TRUE(same(hits[i], quietly)) << "ray " << i;
            ASSERT_TRUE(same(hits[i], observed)) << "ray " << i;
            ASSERT_EQ(text.find("WAS NOT TESTED"), std::string::npos) << text;
            if (!observed.is_hit()) continue;
            std::ostringstream found;
            found.precision(9);
            found << ": hit at t " << double(observed.t) << '\n';
            ASSERT_NE(text.find(found.str()), std::string::npos) << found.str() << text;
            EXPECT_GT(cost.tests, 0u);
            EXPECT_GT(cost.igrids, 0u);
            EXPECT_EQ(cost.igrids_built, 0u) << "the first ray has built them";
            ++told;
        }
    EXPECT_GT(told, 0u);
}

TEST(Trees, FindTheSameBitsForARayThatIsObserved)
{
    for (const lod::LevelMode mode : {lod::LevelMode::PerRay, lod::LevelMode::PerInstance}) {
        Stage stage;
        add_all_kinds(stage.scene);
        const accel::Frame kd = stage.frame(-4, mode, TreeKind::Kd), bvh = stage.frame(-4, mode, TreeKind::Bvh);
        expect_observed_as_found(kd, bvh, all_rays(stage.scene.bounds()), 37);
    }
    Stage moving;
    record_flights(moving.scene, 4, 3);
    const accel::Frame kd = moving.frame(-3, lod::LevelMode::PerRay, TreeKind::Kd), bvh = moving.frame(-3);
    std::vector<accel::Ray> rays = rays_towards({0.3, 3, 9}, {Vec3d(-3), Vec3d(3)}, 400, 5);
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i].time = float(i % 101) / 100;
    expect_observed_as_found(kd, bvh, rays, 7);
}

TEST(Trees, FindTheSameBitsForRaysAloneAndHoweverTheyAreBuilt)
{
    Stage stage;
    add_all_kinds(stage.scene);
    const accel::Frame kd = stage.frame(-4, lod::LevelMode::PerRay, TreeKind::Kd),
                       bvh = stage.frame(-4, lod::LevelMode::PerRay, TreeKind::Bvh);
    const auto rays = all_rays(stage.scene.bounds());
    accel::Tracer in_kd(kd, kPlenty), alone(bvh, kPlenty);
    const Answers expected(in_kd, rays);
    Answers answers(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) answers.ask(alone, rays, i, 1);
    expect_same(expected, answers, "alone");
    for (int on = 0; on < 4; ++on) {
        accel::Tracer tracer(bvh, kPlenty, {(on & 1) != 0, (on & 2) != 0, true});
        EXPECT_EQ(tracer.counters().kd_nodes > 0, (on & 1) == 0) << "built before the first ray, unless lazily";
        expect_same(expected, Answers(tracer, rays), "techniques " + std::to_string(on));
    }
}

TEST(Trees, FindTheSameBitsInATreeThatTracersShare)
{
    Stage stage;
    add_all_kinds(stage.scene);
    const accel::Frame kd = stage.frame(-4, lod::LevelMode::PerRay, TreeKind::Kd),
                       bvh = stage.frame(-4, lod::LevelMode::PerRay, TreeKind::Bvh);
    const auto rays = all_rays(stage.scene.bounds());
    accel::Tracer in_kd(kd, kPlenty);
    const Answers expected(in_kd, rays);
    for (const std::size_t budget : {kPlenty, in_kd.counters().peak_bytes / 4}) {
        accel::SharedTree tree(bvh, budget);
        Answers answers(rays.size());
        ask_in_threads(tree, rays, 250, answers);
        expect_same(expected, answers, "shared");
        EXPECT_EQ(tree.counters().flushes > 0, budget != kPlenty);
    }
}

// Boxes whose sizes and places double from one to the next, and thousands in one place, make the worst trees.
TEST(Trees, GrowWhereBoxesLieInOnePlaceOrAreSpreadOverAllScales)
{
    Stage stage;
    const CageId drum = stage.scene.add(prism(5));
    for (int k = 0; k < 60; ++k) place(stage.scene, drum, {std::ldexp(3.0, k / 2 - 10), 0, 0}, std::ldexp(1.0, k / 2 - 10));
    for (int k = 0; k < 1000; ++k) place(stage.scene, drum, {0, 0, 0}, 1e-3);
    const accel::Frame kd = stage.frame(-2, lod::LevelMode::PerInstance, TreeKind::Kd),
                       bvh = stage.frame(-2, lod::LevelMode::PerInstance, TreeKind::Bvh);
    std::vector<accel::Ray> rays = rays_towards({0, 9, 1}, {Vec3d(-1), Vec3d(60, 1, 1)}, 300, 2);
    accel::Tracer in_kd(kd, kPlenty), in_bvh(bvh, kPlenty);
    expect_same(Answers(in_kd, rays), Answers(in_bvh, rays), "all scales");
}

TEST(Trees, FindTheSameBitsWhereThingsMove)
{
    EveryNth some(2);
    for (const int segments : {1, 4})
        for (const double distance : {0.05, 3.0, 40.0}) {
            if (!some.takes()) continue;
            Stage stage;
            record_flights(stage.scene, segments, distance);
            const accel::Frame kd = stage.frame(-3, lod::LevelMode::PerRay, TreeKind::Kd), bvh = stage.frame(-3);
            ASSERT_EQ(bvh.tree(), TreeKind::Bvh) << "the usual tree where something moves";
            std::vector<accel::Ray> rays = rays_towards({0.3, 3, 9}, {Vec3d(-3), Vec3d(3)}, 1500, 5);
            std::mt19937 random(4);
            for (accel::Ray& ray : rays) ray.time = float(random() % 5 ? random() % 1000 : random() % 5 * 250) * 0.001f;
            accel::Tracer in_kd(kd, kPlenty), in_bvh(bvh, kPlenty);
            const Answers expected(in_kd, rays);
            const std::string where = std::to_string(segments) + " segments, " + std::to_string(distance) + " far";
            expect_same(expected, Answers(in_bvh, rays), where);
            std::size_t hits = 0;
            for (const accel::SurfaceHit& hit : expected.hits) hits += hit.is_hit();
            EXPECT_GT(hits, rays.size() / 8) << where;
            accel::Tracer alone(bvh, kPlenty), tight(bvh, in_bvh.counters().peak_bytes / 4);
            Answers answers(rays.size());
            for (std::size_t i = 0; i < rays.size(); ++i) answers.ask(alone, rays, i, 1);
            expect_same(expected, answers, where + ", alone");
            expect_same(expected, Answers(tight, rays), where + ", a quarter of the memory");
            EXPECT_GT(tight.counters().flushes, 0u);
        }
}

// Smooth and flat cages that fly far in all directions, along paths with a bend: nodes of the tree halve the shutter, and
// each cage moves along chords of as few segments as its own size and distance allow.
void record_swarm(Scene& scene, int segments)
{
    std::mt19937 random(6);
    const auto anywhere = [&] {
        Vec3d p(0);
        for (int a = 0; a < 3; ++a) p[a] = double(random() % 2001) * 0.009 - 9;
        return p;
    };
    Cage sharp = prism(3);
    sharp.scheme = Scheme::Bilinear;
    const CageId smooth = scene.add(prism(4)), flat = scene.add(std::move(sharp));
    std::vector<NodeId> nodes;
    std::vector<std::array<Vec3d, 3>> places;
    for (int k = 0; k < 400; ++k) {
        places.push_back({anywhere(), anywhere(), anywhere()});
        nodes.push_back(place(scene, k % 2 ? smooth : flat, places.back()[0], 0.6));
    }
    scene.record_shutter(segments, [&](double tau) {
        constexpr double kBend = 0.58;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            Trs trs;
            trs.translation = tau < kBend ? glm::mix(places[k][0], places[k][1], tau / kBend)
                                          : glm::mix(places[k][1], places[k][2], (tau - kBend) / (1 - kBend));
            trs.scale = Vec3d(0.6);
            scene.set_transform(nodes[k], trs);
        }
    });
}

TEST(Trees, FindTheSameBitsWhereManyThingsFlyFarAlongBentPaths)
{
    EveryNth some(2);
    for (const int level : {0, -3})
        for (const int segments : {2, 8, 32}) {
            if (!some.takes()) continue;
            Stage stage;
            record_swarm(stage.scene, segments);
            const accel::Frame kd = stage.frame(level, lod::LevelMode::PerRay, TreeKind::Kd), bvh = stage.frame(level);
            std::vector<accel::Ray> rays = rays_towards({2, 3, 30}, {Vec3d(-9), Vec3d(9)}, 4000, 9);
            std::mt19937 random(5);
            for (accel::Ray& ray : rays) ray.time = float(random() % 8 ? random() % 1000 : random() % 5 * 250) * 0.001f;
            accel::Tracer in_kd(kd, kPlenty), in_bvh(bvh, kPlenty), alone(bvh, kPlenty);
            const Answers expected(in_kd, rays);
            const std::string where = std::to_string(segments) + " segments, level " + std::to_string(level);
            expect_same(expected, Answers(in_bvh, rays), where);
            std::size_t hits = 0;
            for (const accel::SurfaceHit& hit : expected.hits) hits += hit.is_hit();
            EXPECT_GT(hits, rays.size() / 4) << where;
            Answers answers(rays.size());
            for (std::size_t i = 0; i < rays.size(); ++i) answers.ask(alone, rays, i, 1);
            expect_same(expected, answers, where + ", alone");
        }
}

// In the kd-tree all parts of a finely diced body that flies lie in one place.
TEST(Trees, OfPlanesRefuseWhatPassesThroughOnePlaceInHundredsOfThousandsOfParts)
{
    Stage stage;
    const NodeId node = place(stage.scene, stage.scene.add(torus()), {0, 0, 0});
    stage.scene.record_shutter(
        1, [&](double tau) { stage.scene.set_transform(node, Trs{.translation = Vec3d(60 * tau), .scale = Vec3d(50)}); });
    const accel::Frame kd = stage.frame(-7, lod::LevelMode::PerRay, TreeKind::Kd), bvh = stage.frame(-7);
    accel::Ray ray;
    ray.origin = {80, 200, 30};
    ray.direction = {0, -1, 0};
    ray.time = 0.5f;
    accel::SurfaceHit hit;
    accel::Tracer in_bvh(bvh, kPlenty), in_kd(kd, kPlenty);
    in_bvh.closest({&ray, 1}, {&hit, 1});
    EXPECT_TRUE(hit.is_hit());
    try {
        in_kd.closest({&ray, 1}, {&hit, 1});
        ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("pass through one place"), std::string::npos) << error.what();
    }
}

// The distances of boxes from such an origin are infinite, and their sums are no numbers.
TEST(Trees, FindTheSameBesideARayThatStartsVeryFarAway)
{
    Stage stage;
    place(stage.scene, stage.scene.add(torus_mesh(20, 12)), {0, 0, 0});
    place(stage.scene, stage.scene.add(torus()), {0, 1, 0});
    for (const TreeKind kind : {TreeKind::Kd, TreeKind::Bvh}) {
        const accel::Frame frame = stage.frame(-3, lod::LevelMode::PerRay, kind);
        accel::Tracer tracer(frame, kPlenty);
        std::vector<accel::Ray> rays(16);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays[i].origin = {1 + 0.02 * double(i % 4), 5, 0.02 * double(i / 4)};
            rays[i].direction = {0, -1, 0};
        }
        std::vector<accel::SurfaceHit> expected(rays.size()), hits(rays.size());
        tracer.closest(rays, expected);
        for (const double far : {-1e29, -1e21, 1e21, 1e29})
            for (std::size_t place = 0; place < rays.size(); ++place) {
                std::vector<accel::Ray> with_far = rays;
                with_far[place].origin.x = far;
                tracer.closest(with_far, hits);
                for (std::size_t i = 0; i < rays.size(); ++i) {
                    if (i == place) continue;
                    ASSERT_TRUE(expected[i].is_hit());
                    ASSERT_TRUE(same(hits[i], expected[i])) << far << " in " << place << ", ray " << i;
                }
            }
    }
}

}  // namespace
}  // namespace occam::test
