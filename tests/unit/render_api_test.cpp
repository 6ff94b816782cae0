// Tests of the facade: rendering, jobs and queries as an application uses them.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "occam/occam.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

// Holds a scene with a square of side 2 at z = 0, facing +z, made of two triangles.
struct Square {
    Scene scene;
    NodeId node;

    Square()
    {
        Cage cage;
        cage.scheme = Scheme::Triangles;
        cage.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        cage.face_vertices = {0, 1, 2, 0, 2, 3};
        NodeDesc desc;
        desc.cages = {scene.add(std::move(cage))};
        node = scene.add_node(scene.root(), desc);
    }
};

const Camera kFront = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f);

TEST(Api, APictureOfASquareHasItsDepthAndCoverage)
{
    Square square;
    Renderer renderer({.threads = 2});
    const Image image = renderer.render(square.scene, kFront,
                                        {.width = 40, .height = 40, .spp = 4, .aovs = Aov::Depth | Aov::Albedo});
    const std::size_t middle = 20 * 40 + 20;
    EXPECT_NEAR(image.find("depth")->pixels[middle], 5, 1e-4);
    EXPECT_TRUE(std::isinf(image.find("depth")->pixels[0]));
    EXPECT_EQ(image.find("albedo")->pixels[4 * middle + 3], 1);
    EXPECT_EQ(image.find("albedo")->pixels[3], 0);
    EXPECT_TRUE(renderer.stats().complete);
    EXPECT_EQ(renderer.stats().rays.primary, 40u * 40 * 4);
    EXPECT_EQ(renderer.stats().image.checksum, image.checksum());
}

// Seen from straight above by an orthographic camera, a flat sheet has one cell for each pixel, for any number of samples.
// Rates that are powers of two, and pairs of levels, build 1 to 4.5 quads for each cell (4.7 is the mean over scales of what
// both directions need). Tiles that are partly out of sight add some more.
TEST(Api, StatisticsTellQuadsPerVisibleCell)
{
    Scene scene;
    Cage sheet;
    sheet.scheme = Scheme::Bilinear;
    sheet.positions = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
    sheet.face_vertices = {0, 1, 2, 3};
    sheet.face_sizes = {4};
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(sheet))}});
    AreaLight lamp;
    lamp.size = Vec2f(1);
    scene.add_node(scene.root(), {.place = {.translation = {0, 0, 8}}, .light = scene.add(Light{"lamp", lamp})});
    Camera camera = kFront;
    camera.lens.orthographic = true;
    camera.lens.height = 6;
    Renderer renderer({.threads = 1});
    renderer.render(scene, camera, {.width = 96, .height = 96, .spp = 3});
    const FrameStats& stats = renderer.stats();
    EXPECT_NEAR(stats.built.visible_cells, 96 * 96, 1e-3);
    const double quads = stats.built.quads_per_cell(stats.built.by_camera_rays);
    EXPECT_GT(quads, 0.9);
    EXPECT_LT(quads, 6);
    // Beams to a lamp leave the surface as wide as they arrived and then grow, so they see grids that exist already, or
    // coarser ones.
    EXPECT_LT(stats.built.quads_per_cell(stats.built.by_shadow_rays), quads);
}

TEST(Api, ACropIsThatPartOfThePicture)
{
    Square square;
    Renderer renderer;
    const Settings whole{.width = 60, .height = 40, .spp = 2};
    Settings part = whole;
    part.crop_x0 = 0.25f, part.crop_x1 = 0.75f, part.crop_y0 = 0.5f;
    const Image a = renderer.render(square.scene, kFront, whole), b = renderer.render(square.scene, kFront, part);
    ASSERT_EQ(b.width, 30);
    ASSERT_EQ(b.height, 20);
    for (int y = 0; y < b.height; ++y)
        for (int c = 0; c < 30 * 4; ++c)
            ASSERT_EQ(b.layers()[0].pixels[std::size_t(y * 30 * 4 + c)],
                      a.layers()[0].pixels[std::size_t(((y + 20) * 60 + 15) * 4 + c)]);
}

TEST(Api, ACancelledJobKeepsItsFinishedTilesAndLetsGoOfTheScene)
{
    Square square;
    Renderer renderer({.threads = 1});
    Job job = renderer.start(square.scene, kFront, {.width = 1000, .height = 1000, .spp = 4096});
    EXPECT_THROW(square.scene.set_visible(square.node, false), Error) << "edits while a frame renders are refused";
    EXPECT_THROW(renderer.start(square.scene, kFront), Error) << "one frame at a time";
    EXPECT_FALSE(job.wait_for(1ms));
    job.cancel();
    job.wait();
    EXPECT_FALSE(job.stats().complete);
    EXPECT_EQ(job.progress().stage, Stage::Done);
    EXPECT_EQ(job.image().width, 1000);
    square.scene.set_visible(square.node, false);
    const Image empty = renderer.render(square.scene, kFront, {.width = 8, .height = 8, .spp = 1, .aovs = Aov::Depth});
    for (float z : empty.find("depth")->pixels) EXPECT_TRUE(std::isinf(z));
}

TEST(Api, AJobThatIsDroppedStops)
{
    Square square;
    Renderer renderer;
    {
        const Job job = renderer.start(square.scene, kFront, {.width = 2000, .height = 2000, .spp = 4096});
    }
    square.scene.set_visible(square.node, false);
}

TEST(Api, ADeadlineEndsAFrame)
{
    Square square;
    Renderer renderer;
    const int side = test::is_long() ? 2000 : 500;
    const Image image = renderer.render(square.scene, kFront,
                                        {.width = side, .height = side, .spp = 65536, .deadline_s = 0.05});
    EXPECT_EQ(image.width, side);
    EXPECT_FALSE(renderer.stats().complete);
}

TEST(Api, AnEmptySceneIsAPictureOfTheSky)
{
    Scene scene;
    Renderer renderer;
    const Image image = renderer.render(scene, Camera::framing(scene.bounds()), {.width = 16, .height = 16, .spp = 1});
    EXPECT_GT(image.layers()[0].pixels[0], 0);
}

TEST(Api, BadSettingsAreRefusedBeforeTheFirstTile)
{
    Square square;
    Renderer renderer;
    EXPECT_THROW(renderer.render(square.scene, kFront, {.width = 0}), Error);
    square.scene.environment.radiance.x = NAN;
    EXPECT_THROW(renderer.render(square.scene, kFront, {.width = 4, .height = 4, .spp = 1}), Error);
    square.scene.environment = {};
    renderer.render(square.scene, kFront, {.width = 4, .height = 4, .spp = 1});
}

TEST(Query, FindsTheNearestSurfaceAndWhatIsBetween)
{
    Square square;
    Query query(square.scene, kFront);
    const auto hit = query.closest({0.25, 0.5, 3}, {0, 0, -2});
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->distance, 3, 1e-6);
    EXPECT_LT(glm::length(hit->position - Vec3d(0.25, 0.5, 0)), 1e-6);
    EXPECT_EQ(hit->node, square.node);
    EXPECT_GT(hit->normal_geometric.z, 0.999f);
    EXPECT_FALSE(query.closest({0, 0, 3}, {0, 0, -1}, 2.9).has_value());
    EXPECT_FALSE(query.closest({3, 0, 3}, {0, 0, -1}).has_value());
    EXPECT_FALSE(query.closest({0, 0, 3}, {0, 0, 0}).has_value());
    EXPECT_FALSE(query.closest({NAN, 0, 3}, {0, 0, -1}).has_value());
    EXPECT_TRUE(query.is_occluded({0, 0, 1}, {0, 0, -1}));
    EXPECT_FALSE(query.is_occluded({0, 0, 2}, {0, 0, 1}));
    EXPECT_THROW(square.scene.set_visible(square.node, false), Error);
}

TEST(Query, FindsFirstHitsOfManyRays)
{
    Square square;
    Query query(square.scene, kFront);
    const std::vector<QueryRay> rays{
        {{0.25, 0.5, 3}, {0, 0, -2}}, {{0, 0, 3}, {0, 0, -1}, 2.9}, {{0, 0, 3}, {0, 0, 0}}, {{0, NAN, 3}, {0, 0, -1}}};
    std::vector<FirstHit> hits(rays.size());
    query.first_hits(rays, hits);
    EXPECT_NEAR(hits[0].distance, 3, 1e-6);
    EXPECT_EQ(hits[0].node, square.node);
    for (std::size_t i = 1; i < rays.size(); ++i) EXPECT_TRUE(std::isinf(hits[i].distance)) << i;
    std::vector<FirstHit> too_few(1);
    EXPECT_THROW(query.first_hits(rays, too_few), Error);
}

// Of a node's cages, one is made on demand and one is replaced; a second node shows one of them again.
TEST(Query, NamesTheCageThatWasHit)
{
    const auto at = [](float x) {
        Cage cage = test::unit_square();
        for (Vec3f& p : cage.positions) p.x += x;
        return cage;
    };
    Scene scene;
    OnDemandCage late;
    late.bounds = {{2, 0, 0}, {3, 1, 0}};
    late.materials = {MaterialId()};  // the default one, as for other cages
    late.make = [=] { return at(2); };
    const CageId first = scene.add(at(0)), second = scene.add(std::move(late));
    const NodeId node = scene.add_node(scene.root(), {.cages = {first, second}});
    const NodeId other = scene.add_node(scene.root(), {.place = {.translation = {4, 0, 0}}, .cages = {first}});
    scene.replace(first, at(0));
    const Query query(scene, kFront);
    struct Case {
        double x;
        NodeId node;
        CageId cage;
    };
    for (const Case& c : {Case{0.5, node, first}, {2.5, node, second}, {4.5, other, first}}) {
        const QueryRay ray{{c.x, 0.5, 3}, {0, 0, -1}};
        const auto hit = query.closest(ray);
        ASSERT_TRUE(hit) << c.x;
        EXPECT_EQ(hit->node, c.node) << c.x;
        EXPECT_EQ(hit->cage, c.cage) << c.x;
        FirstHit found;
        query.first_hits({&ray, 1}, {&found, 1});
        EXPECT_EQ(found.node, c.node) << c.x;
        EXPECT_EQ(found.cage, c.cage) << c.x;
    }
}

// Many threads ask one query, each in its own order, while the renderer that shares its tables renders this scene and
// another.
TEST(Query, AnswersManyThreadsAsItAnswersOne)
{
    Square square, other;
    Renderer renderer;
    const Query query(renderer, square.scene, kFront);
    const auto ray = [](int i) { return QueryRay{{-1.3 + 0.02 * i, 0.3, 3}, {0.05, 0.01 * (i % 7), -1}}; };
    constexpr int kRays = 128;
    std::vector<double> expected(kRays);
    for (int i = 0; i < kRays; ++i) {
        const auto hit = query.closest(ray(i));
        expected[std::size_t(i)] = hit ? hit->distance : -1;
    }
    std::atomic<int> wrong = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 6; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < kRays; ++i) {
                const int k = (i * 37 + t * 11) % kRays;
                const auto hit = query.closest(ray(k));
                wrong += (hit ? hit->distance : -1) != expected[std::size_t(k)];
                wrong += query.is_occluded(ray(k)) != hit.has_value();
            }
        });
    const Settings small{.width = 16, .height = 16, .spp = 1};
    renderer.render(square.scene, kFront, small);
    renderer.render(other.scene, kFront, small);
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, 0);
}

TEST(Query, OutlivesEdits)
{
    Square square;
    auto renderer = std::make_unique<Renderer>();
    Query query(*renderer, square.scene, kFront);
    renderer.reset();
    EXPECT_NEAR(query.closest({0, 0, 3}, {0, 0, -1})->distance, 3, 1e-6);
    query.end();
    EXPECT_THROW(query.closest({0, 0, 3}, {0, 0, -1}), Error);
    EXPECT_THROW(query.pick(1, 1, 8), Error);
    square.scene.set_transform(square.node, Trs{.translation = {0, 0, 1}});
    query.begin(kFront);
    EXPECT_NEAR(query.closest({0, 0, 3}, {0, 0, -1})->distance, 2, 1e-6);
    EXPECT_THROW(square.scene.set_visible(square.node, false), Error);
}

// What was made for cages is forgotten when another scene is asked about, as for removed cages, but not while a query about
// them is begun. A kept query that was ended between frames had all cages of all frames.
TEST(Query, ThatWasEndedKeepsNoTablesAlive)
{
    Scene scene;
    std::atomic<int> made = 0;
    OnDemandCage cage;
    cage.bounds = {Vec3d(-1), Vec3d(1)};
    Square other;
    cage.make = [&] { return ++made, other.scene.cage(other.scene.node(other.node).cages[0]).cage; };
    scene.add_node(scene.root(), {.cages = {scene.add(cage)}});
    Renderer renderer;
    const Settings settings{.width = 4, .height = 4, .spp = 1};
    Query query(renderer, scene, kFront), another(renderer, other.scene, kFront);
    const auto ask = [&] { ASSERT_TRUE(query.closest(Vec3d(0.1, 0.2, 5), Vec3d(0, 0, -1))); };
    ask();
    another.end();
    renderer.render(other.scene, kFront, settings);
    another.begin(kFront);
    ask();
    EXPECT_EQ(made, 1) << "the query was not ended";
    another.end();
    query.end();
    renderer.render(other.scene, kFront, settings);
    query.begin(kFront);
    ask();
    EXPECT_EQ(made, 2) << "a frame of another scene";
    query.end();
    another.begin(kFront);
    query.begin(kFront);
    ask();
    EXPECT_EQ(made, 3) << "a query about another scene";
}

// A game may keep a query about its level while it renders other scenes: what these have no longer is forgotten all the
// same.
TEST(Query, KeepsTheTablesOfItsOwnSceneAlone)
{
    Square level, other;
    Scene scene;
    std::atomic<int> made = 0;
    OnDemandCage cage;
    cage.bounds = {Vec3d(-1), Vec3d(1)};
    cage.make = [&] { return ++made, level.scene.cage(level.scene.node(level.node).cages[0]).cage; };
    scene.add_node(scene.root(), {.cages = {scene.add(cage)}});
    Renderer renderer;
    const Settings settings{.width = 4, .height = 4, .spp = 1};
    const Query query(renderer, level.scene, kFront);
    renderer.render(scene, kFront, settings);
    renderer.render(scene, kFront, settings);
    EXPECT_EQ(made, 1);
    renderer.render(other.scene, kFront, settings);
    renderer.render(scene, kFront, settings);
    EXPECT_EQ(made, 2) << "the tables were kept as long as the query was not ended";
    EXPECT_TRUE(query.closest(Vec3d(0.1, 0.2, 5), Vec3d(0, 0, -1)));
}

// The limit surface of a cube's cage lies 1/6 of a side inside the middles of its faces. A wide beam sees a coarse mesh.
TEST(Query, TakesTheFootprintOfEachRay)
{
    Scene scene;
    Cage cube;
    cube.positions = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
    cube.face_sizes.assign(6, 4);
    cube.face_vertices = {3, 2, 1, 0, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 1, 2, 6, 5, 3, 0, 4, 7};
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(cube))}});
    const Query query(scene, kFront);
    const QueryRay ray{{0.31, 0.23, 3}, {0, 0, -1}};
    const auto at = [&](float width) {
        QueryRay asked = ray;
        asked.footprint = RayFootprint{width, 0};
        return query.closest(asked)->distance;
    };
    EXPECT_NEAR(at(1e-3f), query.closest(ray)->distance, 1e-4);
    EXPECT_GT(std::abs(at(2.0f) - at(1e-3f)), 1e-2);
    QueryRay bad = ray;
    for (const RayFootprint f : {RayFootprint{-1, 0}, RayFootprint{NAN, 0}, RayFootprint{1, INFINITY}}) {
        bad.footprint = f;
        EXPECT_THROW(query.closest(bad), Error);
    }
}

TEST(Query, PicksWhatAPixelShows)
{
    Square square;
    Query query(square.scene, kFront, 100);
    EXPECT_TRUE(query.pick(50, 50, 100).has_value());
    EXPECT_FALSE(query.pick(1, 1, 100).has_value());
}

TEST(Api, ACameraThatIsNowhereIsRefused)
{
    Square square;
    Renderer renderer;
    Query query(square.scene, kFront);
    const auto refuses = [&](auto change) {
        Camera camera = kFront;
        change(camera);
        EXPECT_THROW(renderer.render(square.scene, camera, {.width = 4, .height = 4, .spp = 1}), Error);
        EXPECT_THROW(query.begin(camera), Error);
        EXPECT_THROW(Query(square.scene, camera), Error);
    };
    refuses([](Camera& c) { c.world_from_camera[3][0] = NAN; });
    refuses([](Camera& c) { c.world_from_camera[1][2] = INFINITY; });
    refuses([](Camera& c) { c.world_from_camera = Mat4d(0); });
    refuses([](Camera& c) { c.keys = {c.world_from_camera, Mat4d(0)}; });
    refuses([](Camera& c) { c.keys = {c.world_from_camera, Mat4d(NAN)}; });
    refuses([](Camera& c) { c.lens.fov = NAN; });
    refuses([](Camera& c) { c.lens.orthographic = true, c.lens.height = NAN; });
    refuses([](Camera& c) { c.lens.radius = NAN; });
    refuses([](Camera& c) { c.lens.focus = NAN; });
    EXPECT_NO_THROW(query.begin(kFront));
}

}  // namespace
}  // namespace occam
