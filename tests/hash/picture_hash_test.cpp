// Tests that pictures have the same bits for any number of threads and any budget, and, with OCCAM_HASHES, for another build
// of the same sources.
//
// OCCAM_HASHES names a file. With OCCAM_HASHES_MODE=write this build writes its checksums there; with `compare` its
// checksums have to equal those in the file.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "tests/support/campaign.h"
#include "tests/support/random_case.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

Scene stage(bool is_displaced)
{
    Scene scene;
    Cage rings = torus();
    UvSet uv;
    for (std::size_t v = 0; v < rings.positions.size(); ++v)
        uv.values.push_back(Vec2f(rings.positions[v].x, rings.positions[v].y));
    rings.uv_sets = {uv};
    Texture checks;
    checks.width = checks.height = 8;
    for (int k = 0; k < 64; ++k)
        checks.pixels.push_back((k + k / 8) % 2 ? Vec4f(0.9f, 0.7f, 0.2f, 1) : Vec4f(0.1f, 0.2f, 0.4f, 1));
    Material painted;
    painted.base_color_texture.texture = scene.add(std::move(checks));
    if (is_displaced) {
        Displacement moves;
        moves.texture.texture = painted.base_color_texture.texture;
        moves.scale = 0.1f;
        moves.bound = 0.04f;
        rings.displacement = moves;
    }
    painted.roughness = 0.35f;
    rings.materials = {scene.add(painted)};
    const CageId ring = scene.add(std::move(rings));
    place(scene, ring, {0, 0, 0});
    place(scene, ring, {1.3, 0.4, -0.8}, 0.5);
    place(scene, scene.add(prism(7)), {-1.2, 0.3, 0.6}, 0.5);
    add_lamp(scene, {1, 4, 2});
    return scene;
}

struct Outcome {
    std::uint64_t checksum;
    std::size_t arena_bytes;
    std::uint64_t flushes;
};

Outcome render(Scene& scene, const Camera& camera, const Settings& settings, int threads, std::size_t memory,
               TreeKind tree = TreeKind::Auto)
{
    Renderer renderer({.threads = threads, .memory_bytes = memory, .tree = tree});
    Job job = renderer.start(scene, camera, settings);
    const Image& image = job.image();
    const FrameStats& stats = job.stats();
    return {image.checksum(), stats.memory.arena_peak_bytes, stats.memory.flushes};
}

constexpr const char* kNoOtherBuild = "OCCAM_HASHES is not set: no other build is compared";

/// Returns whether checksums are written for another build, or compared with those of another one.
bool compares_builds() { return std::getenv("OCCAM_HASHES") && std::getenv("OCCAM_HASHES_MODE"); }

/// Writes the checksum or compares it, as the environment says.
void expect_same_in_other_builds(const std::string& name, std::uint64_t checksum)
{
    const char* file = std::getenv("OCCAM_HASHES");
    const char* mode = std::getenv("OCCAM_HASHES_MODE");
    if (!compares_builds()) return;
    std::map<std::string, std::uint64_t> known;
    {
        std::ifstream in(file);
        std::string key;
        std::uint64_t value;
        while (in >> key >> value) known[key] = value;
    }
    if (std::string(mode) == "compare") {
        ASSERT_TRUE(known.count(name)) << name << " is not in " << file;
        EXPECT_EQ(checksum, known[name]) << "another build made another picture";
        return;
    }
    known[name] = checksum;
    std::ofstream out(file);
    for (const auto& [key, value] : known) out << key << ' ' << value << '\n';
}

/// Returns whether only one picture of each scene is made, since another build of the same sources has made the others.
bool is_other_build()
{
    const char* mode = std::getenv("OCCAM_HASHES_MODE");
    return mode && std::string(mode) == "compare" && !is_long();
}

/// What differs between the pictures of a scene by default. In the long form it is both, with each number of threads and
/// each budget.
enum class Differs { Threads, Budget, Both };

void expect_the_same(Scene scene, const std::string& name, Settings settings = {}, std::optional<Camera> moving = {},
                     Differs differs = Differs::Both)
{
    const Camera camera = moving.value_or(Camera::framing(scene.bounds()));
    // The picture is so large that a quarter of the memory that a frame takes is above the least budget.
    settings.width = 320;
    settings.height = 192;
    settings.spp = 4;
    const Outcome one = render(scene, camera, settings, 1, std::size_t(1) << 30);
    EXPECT_EQ(one.flushes, 0u);
    expect_same_in_other_builds(name, one.checksum);
    if (is_other_build()) return;

    struct Way {
        int threads;
        std::size_t part;  // of the memory that was used; 0: enough
        TreeKind tree;
        bool is_long_form, has_other_budget;
    };
    for (const Way& way :
         {Way{2, 0, TreeKind::Auto, true, false}, Way{7, 0, TreeKind::Auto, true, false},
          Way{2, 0, TreeKind::Kd, true, false}, Way{7, 0, TreeKind::Kd, false, false}, Way{2, 4, TreeKind::Bvh, false, true},
          Way{1, 2, TreeKind::Auto, true, true}, Way{1, 4, TreeKind::Auto, true, true}}) {
        const bool is_left_out = way.is_long_form || differs == (way.has_other_budget ? Differs::Threads : Differs::Budget);
        if (is_left_out && !is_long()) continue;
        const std::size_t memory = way.part ? one.arena_bytes / way.part : std::size_t(1) << 30;
        const Outcome other = render(scene, camera, settings, way.threads, memory, way.tree);
        EXPECT_EQ(other.checksum, one.checksum) << way.threads << " threads, tree " << int(way.tree);
        if (way.part) {
            EXPECT_GT(other.flushes, 0u) << "a budget of 1/" << way.part << " of what was used";
        }
    }
}

TEST(Picture, IsTheSameForAnyThreadsAndBudgetAndBuild) { expect_the_same(stage(false), "stage"); }
TEST(Picture, OfDisplacedCagesIsTheSameForAnyThreadsAndBudgetAndBuild) { expect_the_same(stage(true), "displaced"); }

TEST(Picture, ShadedAtVerticesIsTheSameForAnyThreadsAndBudgetAndBuild)
{
    expect_the_same(stage(false), "vertices", {.shade_at = render::ShadeAt::Vertex}, {}, Differs::Budget);
    expect_the_same(stage(true), "displaced_vertices", {.shade_at = render::ShadeAt::Vertex}, {}, Differs::Threads);
}
TEST(Picture, OfDisplacedCagesWithFrozenLevelsIsTheSameForAnyThreadsAndBudgetAndBuild)
{
    expect_the_same(stage(true), "displaced_frozen",
                    {.integrator = IntegratorKind::Path, .bounces = 2, .lod = render::Lod::Frozen});
}

// The ring and the sheets before it have holes, and some of the sheets blend beside.
TEST(Picture, OfWhatHasHolesIsTheSameForAnyThreadsAndBudgetAndBuild)
{
    for (const bool blends : {false, true}) {
        Scene scene = stage(false);
        Texture dots;
        dots.width = dots.height = 16;
        for (int k = 0; k < 256; ++k) dots.pixels.push_back(Vec4f(0.3f, 0.6f, 0.2f, k * 37 % 11 < 4 ? 0.0f : 0.7f));
        Material leaf, veil;
        leaf.base_color_texture.texture = veil.base_color_texture.texture = scene.add(std::move(dots));
        leaf.alpha_mode = AlphaMode::Mask;
        veil.alpha_mode = blends ? AlphaMode::Blend : AlphaMode::Mask;
        const MaterialId leaves = scene.add(leaf), veils = scene.add(veil);
        scene.set_materials(scene.node(scene.root()).children.at(0), {leaves});
        const CageId sheet = scene.add(floor_of(leaves, Scheme::Triangles)),
                     soft = scene.add(floor_of(veils, Scheme::CatmullClark));
        for (int k = 0; k < 12; ++k) place(scene, k % 2 ? sheet : soft, {0, 0.1 * k - 0.5, 0.02 * k}, 0.3);
        expect_the_same(std::move(scene), blends ? "holes_and_blends" : "holes",
                        {.integrator = IntegratorKind::Path, .bounces = 2}, {}, blends ? Differs::Threads : Differs::Budget);
    }
}

/// The campaign compares threads, trees and memory over such scenes; here one build is compared with another.
TEST(Picture, OfRandomScenesIsTheSameInEveryBuild)
{
    if (!compares_builds()) GTEST_SKIP() << kNoOtherBuild;
    for (std::uint64_t seed = 1; seed <= (is_long() ? 100u : 8u); ++seed) {
        const RandomCase c = random_case(seed);
        SCOPED_TRACE(description(c));
        Scene scene = scene_of(c);
        const Camera camera = camera_of(c, scene);
        Renderer renderer({.threads = 1, .memory_bytes = 256u << 20});
        std::uint64_t checksum = 0;  // that of a frame that every build has to refuse
        try {
            checksum = renderer.render(scene, camera, settings_of(c)).checksum();
        } catch (const Error& error) {
            if (!is_hopeless(error)) throw;
        }
        expect_same_in_other_builds("random_" + std::to_string(seed), checksum);
    }
}

// A torus flies, another turns, a displaced one is bent by its vertices, and the camera moves.
TEST(Picture, OfWhatMovesIsTheSameForAnyThreadsAndBudgetAndBuild)
{
    for (const bool is_displaced : {false, true}) {
        Scene scene = stage(is_displaced);
        std::vector<NodeId> rings;
        scene.for_each_placement([&](NodeId id, const Node& node, const Mat4d&) {
            if (!node.cages.empty()) rings.push_back(id);
        });
        const CageId ring = scene.node(rings.at(0)).cages.at(0);
        const std::vector<Vec3f> rest = scene.cage(ring).cage.positions;
        std::vector<Mat4d> places;
        for (const NodeId id : rings) places.push_back(scene.node(id).parent_from_node);
        scene.record_shutter(4, [&](double tau) {
            for (std::size_t i = 0; i < rings.size(); ++i) {
                Trs moves{.translation = {0.3 * tau, 0.1 * double(i) * tau, 0}};
                moves.rotation = {0, tau * 0.5, 0, std::sqrt(1 - tau * tau * 0.25)};
                scene.set_transform(rings[i], places[i] * moves.matrix());
            }
            std::vector<Vec3f> bent = rest;
            for (Vec3f& p : bent) p.y += 0.2f * float(tau) * p.x * p.x;
            scene.write_vertices(ring, bent);
        });
        Camera camera = Camera::framing(scene.bounds());
        for (const double tau : {0.0, 0.5, 1.0}) {
            camera.keys.push_back(camera.world_from_camera);
            camera.keys.back()[3] += Vec4d(0.2 * tau - 0.1, 0, 0, 0);
        }
        expect_the_same(std::move(scene), is_displaced ? "motion_displaced" : "motion", {.bounces = 2}, camera,
                        is_displaced ? Differs::Threads : Differs::Budget);
    }
}

// A displaced cage that its nodes alone move is diced in one pose.
TEST(Picture, OfDisplacedCagesThatFlyIsTheSameForAnyThreadsAndBudgetAndBuild)
{
    Scene scene = stage(true);
    const NodeId ring = scene.node(scene.root()).children.at(0), other = scene.node(scene.root()).children.at(1);
    const Mat4d start = scene.node(ring).parent_from_node, place = scene.node(other).parent_from_node;
    scene.record_shutter(2, [&](double tau) {
        scene.set_transform(ring, start * Trs{.translation = {0.3 * tau, 0.1 * tau, 0}}.matrix());
        scene.set_transform(other, place * Trs{.rotation = {0, tau * 0.5, 0, std::sqrt(1 - tau * tau * 0.25)}}.matrix());
    });
    expect_the_same(std::move(scene), "displaced_flying", {.bounces = 2});
}

// Placed lights and emissive triangles are so many that both are drawn by trees.
TEST(Picture, OfManyLightsIsTheSameForAnyThreadsAndBuild)
{
    Scene scene = stage(false);
    for (int i = 0; i < 90; ++i) {
        const Vec3d at(i % 10 - 4.5, 1.5 + 0.1 * (i % 7), i / 10 - 4.0);
        NodeDesc lamp;
        lamp.place.translation = at;
        AreaLight square;
        square.size = Vec2f(0.2f);
        square.two_sided = i % 5 == 0;
        square.radiance = Vec3f(3);
        lamp.light = i % 2 ? scene.add(Light{"", square}) : scene.add(Light{"", PointLight{Vec3f(0.2f)}});
        scene.add_node(scene.root(), lamp);
    }
    Material shining;
    shining.emission = Vec3f(2);
    Cage lamps;
    lamps.scheme = Scheme::Triangles;
    for (std::uint32_t i = 0; i < 60; ++i) {
        const Vec3f at(float(i % 6) - 2.5f, 2.5f, float(i / 6) * 0.5f - 2.5f);
        for (const Vec3f corner : {Vec3f(0), Vec3f(0.1f, 0, 0), Vec3f(0, 0.05f, 0.1f)})
            lamps.positions.push_back(at + corner);
        for (std::uint32_t k = 0; k < 3; ++k) lamps.face_vertices.push_back(3 * i + k);
    }
    lamps.materials = {scene.add(shining)};
    place(scene, scene.add(std::move(lamps)), {0, 0, 0});
    const Camera camera = Camera::framing(scene.bounds());
    const Settings settings{.width = 96, .height = 54, .spp = 4, .bounces = 2};
    const std::uint64_t one = render(scene, camera, settings, 1, std::size_t(1) << 30).checksum;
    EXPECT_EQ(render(scene, camera, settings, 5, std::size_t(1) << 30).checksum, one);
    expect_same_in_other_builds("many_lights", one);
}

TEST(Picture, OfTheBuiltInSceneIsTheSameInEveryBuild)
{
    if (!compares_builds()) GTEST_SKIP() << kNoOtherBuild;
    Scene scene = builtin_scene();
    Renderer renderer;
    const Image image = renderer.render(scene, scene.camera().value(), {.width = 160, .height = 90, .spp = 1});
    expect_same_in_other_builds("builtin", image.checksum());
}

}  // namespace
}  // namespace occam::test
