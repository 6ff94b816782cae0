// Tests of memory budgets down to the least one, and of trees that workers share: what they may use, and that the picture is
// always the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

#include "accel/memory_floor.h"
#include "base/arena.h"
#include "lod/vertex_shader.h"
#include "occam/occam.h"
#include "render/memory_plan.h"
#include "tests/support/resident_memory.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam {
namespace {

using test::place;
using test::prism;
using test::TexturedFloor;
using test::torus;
using test::waves;

// Holds a few hundred bumpy objects with a lamp, which take several megabytes of trees and igrids.
struct Field {
    Scene scene;
    Camera camera = Camera::look_at({0, 7, 13}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    Settings settings{.width = 160, .height = 96, .spp = 4};

    Field()
    {
        const CageId shapes[] = {scene.add(torus()), scene.add(prism(7))};
        for (int i = 0; i < 144; ++i)
            place(scene, shapes[i % 2], {1.7 * (i % 12 - 5.5), 0.2 * (i % 3), 1.7 * (i / 12 - 5.5)}, 0.5);
        NodeDesc lamp;
        lamp.place.translation = {3, 6, 2};
        lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(60)}});
        scene.add_node(scene.root(), lamp);
    }
    std::uint64_t render(const Resources& resources)
    {
        Renderer renderer(resources);
        const std::uint64_t checksum = renderer.render(scene, camera, settings).checksum();
        stats = renderer.stats();
        return checksum;
    }
    FrameStats stats;
};

TEST(Memory, ABudgetBelowTheFloorIsRefusedAndOneAtTheFloorIsKept)
{
    Field field;
    const std::uint64_t wanted = field.render({.threads = 1, .memory_bytes = std::size_t(1) << 40});
    EXPECT_EQ(field.stats.memory.flushes, 0u);
    const std::uint64_t used = field.stats.memory.arena_peak_bytes;
    test::EveryNth some(2);
    for (const int threads : {1, 2, 5}) {
        if (!some.takes()) continue;
        Resources resources{.threads = threads};
        resources.memory_bytes = Renderer(resources).memory_floor(field.scene);
        EXPECT_EQ(field.render(resources), wanted);
        EXPECT_GT(field.stats.memory.flushes, 0u);
        EXPECT_EQ(field.stats.memory.floor_bytes, resources.memory_bytes);
        // The last igrid of a group of rays is finished before it is dropped.
        EXPECT_LE(field.stats.memory.arena_peak_bytes + field.stats.memory.queue_bytes,
                  resources.memory_bytes + std::size_t(threads) * Arena::kChunkBytes);
        EXPECT_LT(resources.memory_bytes / std::size_t(threads), used / 2) << "the floor is no excuse";
        --resources.memory_bytes;
        try {
            field.render(resources);
            ADD_FAILURE() << "a budget below the floor was accepted";
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("memory budget of"), std::string::npos) << error.what();
        }
    }
}

// A scene whose tracer needs much leaves little for queues of rays, whatever the budget is.
TEST(Memory, TheTracerGetsWhatItNeedsFromAnyBudgetThatIsNotRefused)
{
    for (const std::uint32_t corners : {4u, 300u, 3000u}) {
        Scene scene;
        place(scene, scene.add(prism(corners)), Vec3d(0));
        scene.refit();
        const std::size_t floor = accel::memory_floor(scene);
        for (const int threads : {1, 3}) {
            std::size_t bytes =
                render::plan_memory(scene, {.threads = threads, .memory_bytes = std::size_t(1) << 40}).floor_bytes;
            for (int step = 0; step < 200; ++step, bytes += bytes / 32)
                EXPECT_GE(render::plan_memory(scene, {.threads = threads, .memory_bytes = bytes}).tracer_bytes, floor)
                    << corners << ' ' << threads << ' ' << bytes;
        }
    }
}

TEST(Memory, TheFloorKnowsTheLargestFaceAndNoNumberOfChildren)
{
    const auto floor_of = [](int nodes, std::uint32_t corners) {
        Scene scene;
        const CageId shape = scene.add(prism(corners));
        for (int i = 0; i < nodes; ++i) place(scene, shape, {double(i), 0, 0});
        return Renderer({.threads = 1}).memory_floor(scene);
    };
    EXPECT_LT(floor_of(10, 5), std::size_t(2) << 20);
    EXPECT_LT(floor_of(20'000, 5), floor_of(10, 5) + (std::size_t(1) << 18)) << "children are opened a block at a time";
    EXPECT_GT(floor_of(10, 500), floor_of(10, 5));
}

// One large face makes derived points of the whole cage, which every pose has. What is built beside them has as much room,
// since a tree that is dropped takes them along.
TEST(Memory, TheFloorHoldsTheDerivedPointsOfACageWithALargeFace)
{
    constexpr std::uint32_t kSide = 200;
    Cage cage = prism(65);
    const auto first = static_cast<std::uint32_t>(cage.positions.size());
    for (std::uint32_t i = 0; i <= kSide; ++i)
        for (std::uint32_t j = 0; j <= kSide; ++j) cage.positions.push_back({0.05f * float(i), -2, 0.05f * float(j)});
    for (std::uint32_t i = 0; i < kSide; ++i)
        for (std::uint32_t j = 0; j < kSide; ++j) {
            const std::uint32_t v = first + i * (kSide + 1) + j;
            cage.face_sizes.push_back(4);
            cage.face_vertices.insert(cage.face_vertices.end(), {v, v + 1, v + kSide + 2, v + kSide + 1});
        }
    Scene scene;
    place(scene, scene.add(cage), Vec3d(0));
    const Camera camera = Camera::look_at({3, 3, 8}, {2, -1, 0}, {0, 1, 0}, 0.6f);
    const Settings settings{.width = 24, .height = 16, .spp = 1, .integrator = IntegratorKind::Direct};
    Resources resources{.threads = 1};
    resources.memory_bytes = Renderer(resources).memory_floor(scene);
    EXPECT_GT(resources.memory_bytes, 2 * std::size_t(kSide) * kSide * 4 * sizeof(Vec3f));
    Renderer tight(resources);
    tight.render(scene, camera, settings);
    EXPECT_LE(tight.stats().memory.arena_peak_bytes, resources.memory_bytes + Arena::kChunkBytes);
}

// A node with very many children is opened along the tree over them, where rays go.
TEST(Memory, AFlatListOfNodesHasRoomAtTheFloor)
{
    Scene scene;
    const CageId shape = scene.add(prism(4));
    for (int i = 0; i < 20'000; ++i) place(scene, shape, {2.5 * (i * 7919 % 200), 0, -2.5 * (i * 7919 % 20'000 / 200)});
    const Camera camera = Camera::look_at({250, 3, 8}, {250, 0, -8}, {0, 1, 0}, 0.6f);
    const Settings settings{.width = 24, .height = 16, .spp = 1, .integrator = IntegratorKind::Direct};
    Resources resources{.threads = 1};
    Renderer free(resources);
    const std::uint64_t wanted = free.render(scene, camera, settings).checksum();
    EXPECT_LT(free.stats().memory.arena_peak_bytes, std::size_t(8) << 20) << "of 20,000 nodes a few are seen";
    resources.memory_bytes = Renderer(resources).memory_floor(scene);
    Renderer tight(resources);
    EXPECT_EQ(tight.render(scene, camera, settings).checksum(), wanted);
    EXPECT_LE(tight.stats().memory.arena_peak_bytes, resources.memory_bytes + Arena::kChunkBytes);
}

TEST(Memory, ABudgetAtTheFloorHasRoomForValuesAtVertices)
{
    TexturedFloor world(Scheme::CatmullClark, [](Scene& scene) {
        Material m;
        m.base_color_texture.texture = m.normal_texture.texture = m.bump_texture.texture = scene.add(waves(0));
        m.emission_texture.texture = m.metallic_roughness_texture.texture = m.specular_color_texture.texture = scene.add(
            waves(1));
        m.emission = Vec3f(0.1f);
        return m;
    });
    const Settings settings{.shading_rate = 0.25f, .shade_at = render::ShadeAt::Vertex};
    const std::uint64_t wanted = world.picture(settings).checksum();
    const std::uint64_t used = world.stats.memory.arena_peak_bytes;
    Resources resources{.threads = 1};
    resources.memory_bytes = Renderer(resources).memory_floor(world.scene);
    EXPECT_GT(resources.memory_bytes, std::size_t(8) * 2 * 81 * lod::VertexShader::kMaxChannels * sizeof(float))
        << "of the igrids of a ray";
    world.renderer = Renderer(resources);
    EXPECT_EQ(world.picture(settings).checksum(), wanted);
    EXPECT_GT(world.stats.memory.flushes, 0u);
    EXPECT_LT(resources.memory_bytes, used);
    EXPECT_LE(world.stats.memory.arena_peak_bytes, resources.memory_bytes + Arena::kChunkBytes);
}

TEST(SharedTree, MakesTheSamePictureForAnyGroupsAndBudget)
{
    Field field;
    const std::uint64_t wanted = field.render({.threads = 1});
    test::EveryNth some(2);
    for (const int threads : {2, 5})
        for (const int group : {0, 2, 3}) {
            if (!some.takes()) continue;
            Resources resources{.threads = threads, .workers_a_tree = group};
            EXPECT_EQ(field.render(resources), wanted) << threads << " threads, trees for " << group;
            EXPECT_EQ(field.stats.memory.flushes, 0u);
            resources.memory_bytes = Renderer(resources).memory_floor(field.scene);
            EXPECT_EQ(field.render(resources), wanted) << threads << " threads, trees for " << group << ", at the floor";
            EXPECT_GT(field.stats.memory.flushes, 0u);
        }
}

// Skins and morph targets are posed when rays need them, in the memory of the tree.
TEST(SharedTree, HoldsNoMoreThanOneWorkerNeedsByItself)
{
    Field field;
    field.render({.threads = 1});
    const FrameStats one = field.stats;
    field.render({.threads = 4, .workers_a_tree = 4});
    EXPECT_LE(double(field.stats.memory.arena_peak_bytes), 1.1 * double(one.memory.arena_peak_bytes));
    EXPECT_LE(double(field.stats.built.micropolygons), 1.1 * double(one.built.micropolygons));
}

TEST(Workers, AreCountedEachByItself)
{
    Field field;
    field.render({.threads = 3});
    std::uint64_t tiles = 0, kd_nodes = 0, micropolygons = 0;
    for (const FrameStats::Worker& worker : field.stats.workers) {
        tiles += worker.tiles;
        kd_nodes += worker.kd_nodes;
        micropolygons += worker.micropolygons;
    }
    EXPECT_EQ(tiles, 60u);
    EXPECT_EQ(kd_nodes, field.stats.built.kd_nodes);
    EXPECT_EQ(micropolygons, field.stats.built.micropolygons);
}

// Once a 256th of all samples is made, every pixel shows a sample.
TEST(Deadline, WhatIsNotFinishedShowsASampleOfEachPixel)
{
    Field field;
    field.settings.spp = 256;
    field.settings.deadline_s = 1e9;
    Renderer renderer({.threads = 2});
    Job job = renderer.start(field.scene, field.camera, field.settings);
    while (!(job.progress().fraction > 1.0 / 256)) job.wait_for(std::chrono::milliseconds(1));
    job.cancel();
    const Image& image = job.image();
    EXPECT_FALSE(job.stats().complete);
    const Layer& beauty = *image.find("beauty");
    std::size_t black = 0;
    for (std::size_t i = 0; i < beauty.pixels.size(); i += 4) black += beauty.pixels[i + 3] == 0;
    EXPECT_EQ(black, 0u) << "pixels without a sample";
}

// Places a solid at the end of a chain of nodes.
void hang_below(Scene& scene, NodeId node, int levels)
{
    for (int i = 0; i < levels; ++i) node = scene.add_node(node, {});
    scene.add_node(node, {.name = "deep", .cages = {scene.add(prism(7))}});
}

// The importer accepts trees of 4,096 levels.
TEST(Memory, ADeepNodeIsSeenWithTheLeastMemoryToo)
{
    const Camera camera = Camera::look_at({0, 3, 5}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    const Settings settings{.width = 24, .height = 16, .spp = 2};
    const auto picture_of = [&](int levels, bool moves, Resources resources, bool has_least) {
        Scene scene;
        const NodeId top = scene.add_node(scene.root(), {});
        hang_below(scene, top, levels);
        const auto move = [&](double tau) { scene.set_transform(top, Trs{.translation = {tau, 0, 0}}); };
        if (moves) scene.record_shutter(8, move);
        if (has_least) resources.memory_bytes = Renderer(resources).memory_floor(scene);
        return Renderer(resources).render(scene, camera, settings).checksum();
    };
    Scene empty;
    const std::uint64_t nothing = Renderer().render(empty, camera, settings).checksum();
    for (const bool moves : {false, true}) {
        const std::uint64_t wanted = picture_of(1, moves, {.threads = 1}, false);
        EXPECT_NE(wanted, nothing);
        for (const int levels : {255, 256, 300, 4096})
            EXPECT_EQ(picture_of(levels, moves, {.threads = 2}, false), wanted) << levels;
        EXPECT_EQ(picture_of(4096, moves, {.threads = 1}, true), wanted);
        EXPECT_EQ(picture_of(4096, moves, {.threads = 2}, true), wanted);
    }
}

TEST(Memory, TheFloorHoldsTheLongestWayDownWhetherTheSceneIsRefittedOrNot)
{
    Scene scene;
    const NodeId deep = scene.add_node(scene.root(), {.visible = false});
    hang_below(scene, deep, 1000);
    const Renderer renderer({.threads = 1});
    const auto floor = [&] {
        const std::size_t dirty = renderer.memory_floor(scene), levels = scene.contents().levels;
        scene.refit();
        EXPECT_EQ(renderer.memory_floor(scene), dirty);
        EXPECT_EQ(scene.contents().levels, levels);
        return dirty;
    };
    const std::size_t hidden = floor();
    scene.add_node(scene.root(), {.instance_of = deep});
    const std::size_t shown = floor();
    EXPECT_GT(shown, hidden);
    EXPECT_EQ(scene.contents().levels, 1004u) << "the root, the instance, what it shows, 1,000 nodes and the last one";
    scene.set_visible(deep, true);
    EXPECT_EQ(floor(), shown);
}

// A game makes hundreds of thousands of frames in one process. Each of them had left 7 to 8 KB behind, 2 MB in each block of
// frames here. What the allocator keeps for itself grows in the first frames, too, more so in a process of many tests, but
// ends.
TEST(RenderMemory, FramesLeaveNothingBehind)
{
    if (!test::can_measure_memory()) GTEST_SKIP() << "sanitizers have allocators of their own, or there is no /proc";
    Scene scene;
    place(scene, scene.add(prism(4)), {0, 0, 0}, 1);
    const Camera camera = Camera::look_at({0, 2, 6}, {0, 0, 0}, {0, 1, 0}, 0.9f);
    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(32) << 20});
    const auto growth_in = [&](int frames) {
        const std::size_t before = test::resident_bytes();
        for (int i = 0; i < frames; ++i) renderer.render(scene, camera, {.width = 16, .height = 12, .spp = 1});
        return static_cast<std::ptrdiff_t>(test::resident_bytes()) - static_cast<std::ptrdiff_t>(before);
    };
    growth_in(50);
    const std::ptrdiff_t least = std::min({growth_in(250), growth_in(250), growth_in(250)});
    EXPECT_LT(least, std::ptrdiff_t(1000) << 10);
}

}  // namespace
}  // namespace occam
