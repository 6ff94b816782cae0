// Scenes and cameras of extreme extent, and frames that would take hours: each ends, and a cancelled frame ends soon.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "base/hash.h"
#include "occam/occam.h"
#include "scenegraph/foreign_texture.h"
#include "tests/support/campaign.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"
#include "tests/support/statistics.h"

namespace occam::test {
namespace {

using namespace std::chrono_literals;

Mat4d scaled(double size, Vec3d at = Vec3d(0))
{
    Mat4d m(size);
    m[3] = Vec4d(at, 1);
    return m;
}

/// Renders a small picture. Fails if it does not end, and then does not wait for it any longer than cancelling takes.
void expect_ends(Scene& scene, const Camera& camera, const std::string& what, const Settings& more = {})
{
    Settings settings = more;
    settings.width = 24;
    settings.height = 16;
    settings.spp = 1;
    Renderer renderer({.threads = 2});
    Job job = renderer.start(scene, camera, settings);
    ASSERT_TRUE(job.wait_for(60s)) << what << " does not end";
    EXPECT_EQ(job.stats().image.samples_not_finite, 0u) << what;
}

TEST(Extremes, ScenesOfAnyExtentEnd)
{
    for (const double size : {1e-100, 1e-30, 1e-20, 1e12, 1e20, 1e30, 1e38, 1e100}) {
        Scene scene;
        const CageId cube = scene.add(creased_cube(1));
        scene.add_node(scene.root(), {.matrix = scaled(size), .cages = {cube}});
        expect_ends(scene, Camera::look_at({0, 0, 4 * size}, Vec3d(0), {0, 1, 0}, 0.8f),
                    "a cube of " + std::to_string(size));
        // Beside a cube of the usual size, seen from near that.
        scene.add_node(scene.root(), {.matrix = scaled(1), .cages = {cube}});
        expect_ends(scene, Camera::look_at({0.3, 0.2, 4}, Vec3d(0), {0, 1, 0}, 0.8f), "beside a cube");
    }
}

TEST(Extremes, BoxesOfExtremeProportionsEnd)
{
    for (const double thin : {1e-300, 1e-30, 1e-12}) {
        Scene scene;
        Mat4d plank(1);
        plank[0][0] =
            2e3;  // a grid cell is at most 16 times as long as wide, so the work grows with the length over the width
        plank[1][1] = thin;
        scene.add_node(scene.root(), {.matrix = plank, .cages = {scene.add(creased_cube(1))}});
        Cage displaced = displaced_case(0).cage;
        displaced.displacement.reset();
        scene.add_node(scene.root(), {.matrix = plank, .cages = {scene.add(displaced)}});
        expect_ends(scene, Camera::look_at({0, 3, 4}, Vec3d(0), {0, 1, 0}, 0.8f), "a plank");
    }
}

TEST(Extremes, CamerasOfAnyDistanceAndHeightEnd)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(torus())}});
    for (const double distance : {1e10, 1e20, 1e38, 1e100})
        for (const Lod lod : {Lod::On, Lod::Off})
            expect_ends(scene, Camera::look_at(Vec3d(1, 0.5, 2) * distance, Vec3d(0), {0, 1, 0}, 0.8f), "a far camera",
                        {.lod = lod});
    for (const float height : {1e-30f, 1e-10f, 1e10f, 1e30f})
        for (const Lod lod : {Lod::On, Lod::Off}) {
            Camera camera = Camera::look_at({1, 0.5, 2}, Vec3d(0), {0, 1, 0}, 0.8f);
            camera.lens.orthographic = true;
            camera.lens.height = height;
            expect_ends(scene, camera, "an orthographic camera", {.lod = lod});
        }
}

TEST(Extremes, MatricesThatOverflowEnd)
{
    Scene scene;
    const CageId cage = scene.add(torus());
    NodeId node = scene.root();
    for (int k = 0; k < 3; ++k) node = scene.add_node(node, {.matrix = scaled(1e200), .cages = {cage}});
    expect_ends(scene, Camera::look_at({1, 0.5, 2}, Vec3d(0), {0, 1, 0}, 0.8f), "a chain of scales");
    Scene flat;
    flat.add_node(flat.root(), {.matrix = scaled(0, {1, 2, 3}), .cages = {flat.add(torus())}});
    expect_ends(flat, Camera::look_at({1, 0.5, 8}, Vec3d(0), {0, 1, 0}, 0.8f), "a cage that is a point");
}

/// A quarter of a million instances side by side, named by 36 nodes.
TEST(Extremes, InstancesOfInstancesEnd)
{
    Scene scene;
    NodeId shown = scene.add_node(scene.root(), {.cages = {scene.add(creased_cube(1))}, .visible = false});
    for (int k = 0; k < 18; ++k) {
        const NodeId pair = scene.add_node(scene.root(), {.visible = false});
        scene.add_node(pair, {.instance_of = shown});
        scene.add_node(pair, {.matrix = scaled(1, {4 * std::ldexp(1.0, k), 0, 0}), .instance_of = shown});
        shown = pair;
    }
    scene.add_node(scene.root(), {.instance_of = shown});
    expect_ends(scene, Camera::look_at({30, 8, 20}, {30, 0, 0}, {0, 1, 0}, 0.8f), "instances of instances");
}

/// Adds levels of nodes, each of which shows the one before twice: 2^levels instances of a node, each `step` beside the
/// other. Returns the last level, which is not shown yet.
NodeId doubled(Scene& scene, NodeDesc desc, int levels, double step)
{
    desc.visible = false;
    NodeId shown = scene.add_node(scene.root(), desc);
    for (int k = 0; k < levels; ++k) {
        const NodeId both = scene.add_node(scene.root(), {.name = "level " + std::to_string(k), .visible = false});
        scene.add_node(both, {.instance_of = shown});
        scene.add_node(both, {.matrix = scaled(1, {step * std::ldexp(1.0, k), 0, 0}), .instance_of = shown});
        shown = both;
    }
    return shown;
}

/// Returns what a frame of the scene is refused with, or nothing if it ends.
std::string refusal(Scene& scene, const Settings& more = {})
{
    Settings settings = more;
    settings.width = 16;
    settings.height = 12;
    settings.spp = 1;
    try {
        Renderer({.threads = 1}).render(scene, Camera::look_at({0.3, 0.2, 4}, Vec3d(0), {0, 1, 0}, 0.8f), settings);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(Extremes, InstancesBeyondCountingEndIfTheyLieSideBySide)
{
    Scene scene;
    scene.add_node(scene.root(), {.instance_of = doubled(scene, {.cages = {scene.add(creased_cube(1))}}, 24, 4)});
    EXPECT_EQ(refusal(scene), "");
    EXPECT_GT(scene.placed_faces(), std::size_t(1) << 24);
    EXPECT_FALSE(Camera::framing(scene.bounds()).world_from_camera == Mat4d(0));
}

TEST(Extremes, InstancesBeyondCountingInOnePlaceAreRefusedByName)
{
    for (const double step : {0.0, 1e-12}) {
        Scene scene;
        const NodeId all = doubled(scene, {.cages = {scene.add(creased_cube(1))}}, 60, step);
        scene.add_node(scene.root(), {.instance_of = all});
        const std::string line = refusal(scene);
        EXPECT_NE(line.find("too many surfaces lie in one place"), std::string::npos) << line;
        EXPECT_NE(line.find("node 'level 1"), std::string::npos) << line;
        EXPECT_EQ(scene.placed_faces(), std::size_t(6) << 60);
    }
}

// A far cube makes the box of each level so large that few rays meet what lies in one place.
TEST(Extremes, InstancesBeyondCountingInOnePlaceBesideFarOnesAreRefused)
{
    Scene scene;
    const CageId cube = scene.add(creased_cube(1));
    NodeId shown = scene.add_node(scene.root(), {.cages = {cube}, .visible = false});
    for (int k = 0; k < 40; ++k) {
        const NodeId both = scene.add_node(scene.root(), {.name = "level", .visible = false});
        scene.add_node(both, {.instance_of = shown});
        scene.add_node(both, {.instance_of = shown});
        scene.add_node(both, {.matrix = scaled(1, {std::ldexp(1e3, k), 0, 0}), .cages = {cube}});
        shown = both;
    }
    scene.add_node(scene.root(), {.instance_of = shown});
    EXPECT_NE(refusal(scene).find("surfaces lie in one place"), std::string::npos) << refusal(scene);
}

// 20,000 meshes or cages in one place are no more than 3 MB of a file, and each ray would meet all of them.
TEST(Extremes, TensOfThousandsOfSurfacesInOnePlaceAreRefused)
{
    for (const bool is_mesh : {false, true}) {
        Scene scene;
        Cage cage = creased_cube(1);
        if (is_mesh) {
            cage = {};
            cage.scheme = Scheme::Triangles;
            cage.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
            cage.face_vertices = {0, 1, 2};
        }
        const CageId id = scene.add(std::move(cage));
        for (int i = 0; i < 20'000; ++i) scene.add_node(scene.root(), {.cages = {id}});
        EXPECT_NE(refusal(scene).find("surfaces lie in one place"), std::string::npos) << refusal(scene);
    }
}

/// Returns triangles at random, each about half as large as the whole.
Cage triangle_soup(std::uint32_t triangles)
{
    Numbers n(11);
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (std::uint32_t v = 0; v < 3 * triangles; ++v) {
        cage.positions.push_back({n.one(), n.one(), n.one()});
        cage.face_vertices.push_back(v);
    }
    return cage;
}

// Each of the meshes, and the number of nodes, is within its limits; a ray would test a million triangles.
TEST(Extremes, InstancesOfMeshesWhoseTrianglesOverlapAreRefused)
{
    Scene scene;
    const CageId soup = scene.add(triangle_soup(2000));
    for (int i = 0; i < 2000; ++i) scene.add_node(scene.root(), {.name = "soup", .cages = {soup}});
    EXPECT_NE(refusal(scene).find("surfaces lie in one place"), std::string::npos) << refusal(scene);
}

// A ray that passes such a triangle starts again behind it, among thousands of boxes.
TEST(Extremes, BlendedTrianglesThatOverlapInThousandsAreRefused)
{
    for (const bool are_nodes : {false, true}) {
        Scene scene;
        Material faint;
        faint.alpha_mode = AlphaMode::Blend;
        faint.base_color.a = 0.01f;
        Cage cage = triangle_soup(are_nodes ? 1 : 60'000);
        cage.materials = {scene.add(faint)};
        const CageId id = scene.add(std::move(cage));
        for (int i = 0; i < (are_nodes ? 8000 : 1); ++i) scene.add_node(scene.root(), {.name = "soup", .cages = {id}});
        EXPECT_NE(refusal(scene).find("surfaces that light passes overlap"), std::string::npos) << refusal(scene);
    }
}

TEST(Extremes, PlanksAsLongAsTheyAreThinEndOrAreRefusedByName)
{
    EveryNth some(2);
    for (const Lod lod : {Lod::On, Lod::Off})
        for (const double size : {1e3, 1e6, 1e12}) {
            if (!some.takes()) continue;
            Scene scene;
            Mat4d plank(1);
            plank[0][0] = size;
            plank[1][1] = 1 / size;
            scene.add_node(scene.root(), {.name = "plank", .matrix = plank, .cages = {scene.add(creased_cube(1))}});
            const std::string why = refusal(scene, {.lod = lod});
            const bool is_named = why.find("too close together for their numbers (node 'plank')") != std::string::npos;
            EXPECT_TRUE(why.empty() || (size > 1e3 && is_named)) << size << ": " << why;
        }
}

// Every ray that is scattered adds the light of each area light that it crosses.
TEST(Extremes, AreaLightsThatOverlapInThousandsAreRefused)
{
    for (const bool has_far_lamp : {false, true}) {
        for (const double spread : {0.001, 3.0}) {
            Scene scene;
            place(scene, scene.add(torus()), Vec3d(0));
            const LightId lamp = scene.add(Light{"lamp", AreaLight{}});
            for (int i = 0; i < 2000; ++i)
                scene.add_node(scene.root(), {.matrix = moved(spread * (i % 50), 2, spread * (i / 50)), .light = lamp});
            if (has_far_lamp) scene.add_node(scene.root(), {.matrix = moved(1e6, 2, 0), .light = lamp});
            EXPECT_EQ(refusal(scene).find("too many area lights lie in one place") == 0, spread < 1) << refusal(scene);
        }
    }
}

// The cages of one node shine, each by a material of its own. What is refused is refused before its lights are gathered.
TEST(Extremes, ThousandsOfCagesOfANodeThatShineAreGatheredOrRefused)
{
    for (const int cages : {3000, 20'000}) {
        Scene scene;
        NodeDesc node;
        for (int i = 0; i < cages; ++i) {
            Material glow;
            glow.emission = Vec3f(1);
            Cage cage = triangle_soup(1);
            cage.materials = {scene.add(glow)};
            node.cages.push_back(scene.add(std::move(cage)));
        }
        scene.add_node(scene.root(), node);
        EXPECT_EQ(refusal(scene).find("surfaces lie in one place") != std::string::npos, cages > 16'384) << refusal(scene);
    }
}

TEST(Extremes, LightsEmittersAndDisplacedCagesBeyondCountingAreRefused)
{
    for (const int what : {0, 1, 2}) {
        Scene scene;
        NodeDesc desc;
        if (what == 0) desc.light = scene.add(Light{"lamp", PointLight{Vec3f(1)}});
        if (what == 1) {
            Material glow;
            glow.emission = Vec3f(1);
            Cage cage = creased_cube(1);
            cage.materials = {scene.add(glow)};
            desc.cages = {scene.add(std::move(cage))};
        }
        if (what == 2) desc.cages = {add_with_foreign_texture(scene, displaced_case(0).cage)};
        scene.add_node(scene.root(), {.instance_of = doubled(scene, desc, 60, 8)});
        place(scene, scene.add(torus()), Vec3d(0));
        EXPECT_NE(refusal(scene).find("placed more than"), std::string::npos) << what << ": " << refusal(scene);
    }
}

// 4,096 quads, each a fraction of a pixel wide, under spikes that are twenty times as high as a quad is wide. A displacement
// is filtered over the edges of a level, so that it does not need vertices closer together than that.
TEST(Extremes, SteepDisplacementsMakeFewMicropolygons)
{
    constexpr std::uint32_t kQuads = 64;
    Scene scene;
    Cage sheet;
    sheet.scheme = Scheme::CatmullClark;
    sheet.uv_sets.resize(1);
    for (std::uint32_t j = 0; j <= kQuads; ++j)
        for (std::uint32_t i = 0; i <= kQuads; ++i) {
            const Vec2f at = Vec2f(float(i), float(j)) / float(kQuads);
            sheet.positions.push_back({at.x - 0.5f, at.y - 0.5f, 0});
            sheet.uv_sets[0].values.push_back(at);
        }
    for (std::uint32_t j = 0; j < kQuads; ++j)
        for (std::uint32_t i = 0; i < kQuads; ++i) {
            const std::uint32_t first = j * (kQuads + 1) + i;
            sheet.face_sizes.push_back(4);
            sheet.face_vertices.insert(sheet.face_vertices.end(),
                                       {first, first + 1, first + kQuads + 2, first + kQuads + 1});
        }
    Texture noise;
    noise.role = TextureRole::Data;
    noise.width = noise.height = 256;
    for (std::uint64_t k = 0; k < 256 * 256; ++k) noise.pixels.push_back(Vec4f(float(mix_bits(k) >> 40) * 0x1p-24f));
    sheet.displacement.emplace();
    sheet.displacement->texture.texture = scene.add(std::move(noise));
    sheet.displacement->scale = 0.3f;
    sheet.displacement->midlevel = 0.5f;
    sheet.displacement->bound = 0.15f;
    scene.add_node(scene.root(), {.cages = {scene.add(std::move(sheet))}});
    Renderer renderer({.threads = 1});
    const Settings settings{.width = 24, .height = 16, .spp = 1, .integrator = IntegratorKind::Direct};
    Job job = renderer.start(scene, Camera::look_at({0, 0, 2}, Vec3d(0), {0, 1, 0}, 0.8f), settings);
    job.wait();
    // A pixel is 0.1 wide, so the finest edges are a 16th long. Without displacement a quad's speed is 2^-6, or 2^-5 if it
    // is rounded up; with it no more than 16 times that: at most 8 by 8 quads, and a quarter of that at the next level.
    EXPECT_GT(job.stats().built.micropolygons, 0u);
    EXPECT_LE(job.stats().built.micropolygons, kQuads * kQuads * 2 * (64 + 16));
}

/// 10,000 cages in one place: each ray meets all of them.
TEST(Cancelling, EndsAFrameInWhichARayMeetsEverything)
{
    Scene scene;
    const CageId cage = scene.add(creased_cube(1));
    for (int k = 0; k < 10'000; ++k) scene.add_node(scene.root(), {.cages = {cage}});
    for (const int workers_a_tree : {1, 0}) {
        Renderer renderer({.threads = 2, .workers_a_tree = workers_a_tree});
        Job job = renderer.start(scene, Camera::look_at({1, 0.5, 4}, Vec3d(0), {0, 1, 0}, 0.8f),
                                 {.width = 64, .height = 48});
        std::this_thread::sleep_for(300ms);
        job.cancel();
        EXPECT_TRUE(job.wait_for(5s)) << "the frame ignores the request to stop";
        EXPECT_FALSE(job.stats().complete);
        EXPECT_EQ(job.image().width, 64);
    }
}

TEST(Extremes, FacesOfThousandsOfCornersAndPolesOfThousandsOfFacesEnd)
{
    Scene scene;
    place(scene, scene.add(prism(3000)), {-1.2, 0, 0});
    place(scene, scene.add(spindle(3000)), {1.2, 0, 0});
    expect_ends(scene, Camera::look_at({1, 2, 5}, Vec3d(0), {0, 1, 0}, 0.8f), "prism and bipyramid");
}

TEST(Cancelling, EndsAFrameWhoseTablesAreInTheMaking)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(prism(4000))}});
    Renderer renderer({.threads = 2});
    Job job = renderer.start(scene, Camera::look_at({1, 2, 4}, Vec3d(0), {0, 1, 0}, 0.8f), {.width = 64, .height = 48});
    std::this_thread::sleep_for(200ms);
    job.cancel();
    EXPECT_TRUE(job.wait_for(5s)) << "the frame ignores the request to stop";
    // What the cancelled frame left behind is whole: the next one renders the same as a new renderer's.
    Scene other;
    other.add_node(other.root(), {.cages = {other.add(prism(9))}});
    const Camera camera = Camera::look_at({1, 2, 4}, Vec3d(0), {0, 1, 0}, 0.8f);
    EXPECT_EQ(renderer.render(other, camera, {.width = 32, .height = 24, .spp = 1}).checksum(),
              Renderer({.threads = 1}).render(other, camera, {.width = 32, .height = 24, .spp = 1}).checksum());
}

}  // namespace
}  // namespace occam::test
