// Tests of a scene that changes between frames: each picture is that of a scene built anew, whatever the renderer has kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "occam/occam.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using test::place;
using test::prism;
using test::torus;

const Camera kCamera = Camera::look_at({0.5, 3, 6}, {0, 0, 0}, {0, 1, 0}, 0.8f);
const Settings kSmall{.width = 64, .height = 48, .spp = 2};

// Holds what an application may have at one moment.
struct State {
    bool is_tall = false, is_prism = false, is_aside = false, is_red = false, is_dark = false, is_hidden = false;
};

Cage body(const State& state, MaterialId material)
{
    Cage cage = state.is_prism ? prism(6) : torus();
    if (state.is_tall)
        for (Vec3f& p : cage.positions) p.y *= 3;
    cage.materials = {material};
    return cage;
}
Material paint(const State& state)
{
    Material m;
    m.base_color = state.is_red ? Vec4f(1, 0, 0, 1) : Vec4f(0.8f);
    return m;
}
Light lamp(const State& state) { return {"", SunLight{Vec3f(state.is_dark ? 0.2f : 3.0f)}}; }
Mat4d site(const State& state)
{
    Mat4d m(1);
    m[3] = Vec4d(state.is_aside ? 1.5 : 0, 0, 0, 1);
    return m;
}

struct World {
    Scene scene;
    MaterialId material;
    CageId cage;
    LightId light;
    NodeId node;

    explicit World(const State& state = {})
    {
        material = scene.add(paint(state));
        cage = scene.add(body(state, material));
        light = scene.add(lamp(state));
        NodeDesc desc;
        desc.matrix = site(state);
        desc.cages = {cage};
        desc.visible = !state.is_hidden;
        node = scene.add_node(scene.root(), desc);
        NodeDesc sun;
        sun.light = light;
        scene.add_node(scene.root(), sun);
        place(scene, scene.add(prism(5)), {-2, 0, 0}, 0.5);
    }
    void become(const State& before, const State& now)
    {
        if (now.is_prism != before.is_prism) scene.replace(cage, body(now, material));
        else if (now.is_tall != before.is_tall) scene.write_vertices(cage, body(now, material).positions);
        if (now.is_red != before.is_red) scene.replace(material, paint(now));
        if (now.is_dark != before.is_dark) scene.replace(light, lamp(now));
        if (now.is_aside != before.is_aside) scene.set_transform(node, site(now));
        if (now.is_hidden != before.is_hidden) scene.set_visible(node, !now.is_hidden);
    }
};

TEST(ChangingScene, EveryFrameIsThatOfASceneBuiltAnew)
{
    World world;
    Renderer renderer;
    State before;
    renderer.render(world.scene, kCamera, kSmall);
    for (const State& now :
         {State{.is_tall = true}, State{.is_tall = true, .is_aside = true}, State{.is_prism = true, .is_aside = true},
          State{.is_tall = true, .is_prism = true, .is_red = true}, State{.is_red = true, .is_dark = true},
          State{.is_hidden = true}, State{}}) {
        world.become(before, now);
        World fresh(now);
        EXPECT_EQ(renderer.render(world.scene, kCamera, kSmall).checksum(),
                  Renderer().render(fresh.scene, kCamera, kSmall).checksum());
        before = now;
    }
}

// Two squares lie in one place, so each ray hits both at one distance.
TEST(ChangingScene, WhatLiesInOnePlaceIsSeenInTheOrderOfTheGraph)
{
    enum class History { None, NodesBefore, NodesRemoved, AnInstance };
    const auto albedo_with = [](History history, int siblings, TreeKind tree) {
        Scene scene;
        std::vector<NodeId> earlier;
        const auto empty_nodes = [&](int count) {
            for (int k = 0; k < count; ++k) earlier.push_back(scene.add_node(scene.root(), {}));
        };
        if (history == History::NodesBefore) empty_nodes(2);
        if (history == History::NodesRemoved) empty_nodes(9);
        for (const NodeId id : earlier) scene.remove(id);  // slots are used again in the reverse order
        std::vector<CageId> squares;
        for (const bool is_red : {true, false}) {
            Cage square = test::textured_square();
            square.materials = {scene.add(paint({.is_red = is_red}))};
            squares.push_back(scene.add(square));
        }
        const NodeId top = scene.add_node(scene.root(), {.name = "squares"});
        if (history == History::AnInstance) scene.add_node(top, {.matrix = test::moved(0, 9, 0)});
        for (const CageId square : squares) scene.add_node(top, {.cages = {square}});
        for (int k = 0; k < siblings; ++k) place(scene, squares[1], {double(5 + k % 20), double(k / 20), -3}, 0.1);
        const Camera camera = Camera::look_at({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 0.6f);
        const Settings settings{.width = 24, .height = 24, .spp = 1, .aovs = {Aov::Albedo}};
        const Image image = Renderer({.threads = 1, .tree = tree}).render(scene, camera, settings);
        return image.find("albedo")->pixels;
    };
    for (const TreeKind tree : {TreeKind::Kd, TreeKind::Bvh})
        for (const int siblings : {0, 400}) {
            const std::vector<float> plain = albedo_with(History::None, siblings, tree);
            EXPECT_GT(plain[0], plain[1] + 0.5f) << "the first one is red";
            for (const History history : {History::NodesBefore, History::NodesRemoved, History::AnInstance})
                EXPECT_EQ(albedo_with(history, siblings, tree), plain) << int(history) << ' ' << siblings;
        }
}

TEST(ChangingScene, EditsWaitForARunningJobAndPassAfterIt)
{
    World world;
    Renderer renderer;
    Settings long_one = kSmall;
    long_one.spp = 4096;
    {
        Job job = renderer.start(world.scene, kCamera, long_one);
        EXPECT_THROW(world.scene.write_vertices(world.cage, world.scene.cage(world.cage).cage.positions), Error);
        EXPECT_THROW(world.scene.replace(world.material, Material{}), Error);
        EXPECT_THROW(world.scene.replace(world.light, Light{}), Error);
        EXPECT_THROW(world.scene.set_transform(world.node, Mat4d(1)), Error);
        EXPECT_THROW(world.scene.set_morph_weights(world.node, {}), Error);
        EXPECT_THROW(world.scene.copy(world.node, world.scene.root()), Error);
        job.cancel();
    }
    EXPECT_NO_THROW(world.scene.set_transform(world.node, Mat4d(1)));
}

OnDemandCage demanded(std::atomic<int>& calls, Cage cage)
{
    OnDemandCage on_demand;
    on_demand.name = "demanded";
    on_demand.bounds = torus().bounds();
    on_demand.make = [&calls, cage] {
        ++calls;
        return cage;
    };
    return on_demand;
}

// Geometry is hidden behind a wall, or lies beside the picture. However much it is, and however it changes, a frame does the
// same work. The test uses one worker, because two divide the work differently each time.
TEST(HiddenGeometry, CostsNoWorkOfAnyKind)
{
    const auto work_with = [](int copies) {
        World world;
        Cage wall;
        wall.scheme = Scheme::Triangles;
        wall.positions = {{-90, -90, -4}, {90, -90, -4}, {0, 180, -4}};
        wall.face_vertices = {0, 1, 2};
        place(world.scene, world.scene.add(wall), {0, 0, 0});
        std::vector<CageId> hidden;
        NodeDesc behind, beside;
        behind.place.translation = {0, 0, -12};
        beside.place.translation = {200, 0, 0};
        for (const NodeId group :
             {world.scene.add_node(world.scene.root(), behind), world.scene.add_node(world.scene.root(), beside)})
            for (int i = 0; i < copies; ++i) {
                hidden.push_back(world.scene.add(torus()));
                NodeDesc desc;
                desc.place.translation = {i % 8 - 4.0, i / 8 % 8 - 4.0, -0.1 * i};
                desc.cages = {hidden.back()};
                world.scene.add_node(group, std::move(desc));
            }
        Renderer renderer({.threads = 1});
        renderer.render(world.scene, kCamera, kSmall);
        for (const CageId cage : hidden) {
            std::vector<Vec3f> positions = world.scene.cage(cage).cage.positions;
            for (Vec3f& p : positions) p.y *= 1.5f;
            world.scene.write_vertices(cage, positions);
        }
        renderer.render(world.scene, kCamera, kSmall);
        return renderer.stats();
    };
    const FrameStats few = work_with(1), many = work_with(64);
    EXPECT_GT(few.built.faces_touched, 0u);
    EXPECT_EQ(few.built.faces_touched, many.built.faces_touched);
    // The planes of the tree differ, so a packet may visit other boxes beside its path.
    EXPECT_NEAR(double(few.built.grids), double(many.built.grids), 0.05 * double(few.built.grids));
    EXPECT_NEAR(double(few.built.micropolygons), double(many.built.micropolygons), 0.05 * double(few.built.micropolygons));
    EXPECT_LE(many.built.kd_nodes, few.built.kd_nodes + 24) << "planes between what is seen and what is not";
    EXPECT_LE(many.memory.arena_peak_bytes, few.memory.arena_peak_bytes + (std::size_t(128) << 10))
        << "the items of two groups";
}

TEST(OnDemandCages, AreMadeWhenSeenAndNotBefore)
{
    std::atomic<int> calls = 0;
    Scene scene;
    place(scene, scene.add(demanded(calls, torus())), {0, 0, 0});
    Cage wall;
    wall.scheme = Scheme::Triangles;
    wall.positions = {{-90, -90, 4}, {90, -90, 4}, {0, 180, 4}};
    wall.face_vertices = {0, 1, 2};
    const NodeId in_front = place(scene, scene.add(wall), {0, 0, 0});
    const Camera camera = Camera::look_at({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.6f);
    Renderer renderer;
    renderer.render(scene, camera, kSmall);
    EXPECT_EQ(calls, 0) << "behind a wall";
    EXPECT_LT(scene.bounds().lo.z, -1) << "its bounds are there all the same";

    scene.set_visible(in_front, false);
    const Image seen = renderer.render(scene, camera, kSmall);
    EXPECT_GE(calls, 1);
    Scene plain;
    place(plain, plain.add(torus()), {0, 0, 0});
    EXPECT_EQ(seen.checksum(), renderer.render(plain, camera, kSmall).checksum());
    const std::size_t floor = Renderer({.threads = 2}).memory_floor(scene);
    EXPECT_EQ(Renderer({.threads = 2, .memory_bytes = floor}).render(scene, camera, kSmall).checksum(), seen.checksum());
}

// The function that makes the cage knows no materials: those of the OnDemandCage are meant.
TEST(OnDemandCages, KeepTheMaterialSlotsOfTheirFaces)
{
    Cage cage = torus();
    for (std::size_t f = 0; f < cage.face_count(); ++f) cage.face_slots.push_back(static_cast<std::uint16_t>(f % 3));
    const auto picture_of = [&](bool is_late) {
        std::atomic<int> calls = 0;
        Scene scene;
        const std::vector<MaterialId> materials{scene.add(paint({})), scene.add(paint({.is_red = true})),
                                                scene.add(Material{})};
        OnDemandCage late = demanded(calls, cage);
        late.materials = materials;
        Cage whole = cage;
        whole.materials = materials;
        place(scene, is_late ? scene.add(std::move(late)) : scene.add(std::move(whole)), {0, 0, 0});
        Renderer renderer;
        return renderer.render(scene, kCamera, kSmall).checksum();
    };
    EXPECT_EQ(picture_of(true), picture_of(false));
}

TEST(OnDemandCages, HaveNoVerticesToWrite)
{
    std::atomic<int> calls{0};
    Scene scene;
    const CageId id = scene.add(demanded(calls, torus()));
    scene.add_node(scene.root(), {.cages = {id}});
    const Box3d before = scene.bounds();
    EXPECT_THROW(scene.write_vertices(id, {}), Error);
    EXPECT_THROW(scene.record_shutter(1, [&](double) { scene.write_vertices(id, {}); }), Error);
    EXPECT_EQ(scene.bounds().lo, before.lo);
    EXPECT_EQ(scene.bounds().hi, before.hi);
}

TEST(OnDemandCages, EndTheFrameWithAClearErrorIfTheyDoNotKeepTheirWord)
{
    std::atomic<int> calls = 0;
    const Camera camera = Camera::look_at({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.6f);
    Cage large = torus();
    for (Vec3f& p : large.positions) p *= 2.0f;
    OnDemandCage fails = demanded(calls, torus());
    fails.make = []() -> Cage { throw std::runtime_error("the disk is gone"); };
    Renderer renderer;
    for (OnDemandCage bad : {demanded(calls, large), fails}) {
        Scene scene;
        place(scene, scene.add(bad), {0, 0, 0});
        EXPECT_THROW(renderer.render(scene, camera, kSmall), std::exception);
    }
    Scene scene;
    place(scene, scene.add(demanded(calls, torus())), {0, 0, 0});
    EXPECT_NO_THROW(renderer.render(scene, camera, kSmall)) << "the renderer goes on";
    EXPECT_THROW(scene.add(OnDemandCage{}), Error);
}

TEST(OnDemandCages, WithoutFacesShowNothing)
{
    std::atomic<int> calls = 0;
    Cage without_faces = torus(), bilinear, dropped = torus();
    without_faces.face_sizes.clear();
    without_faces.face_vertices.clear();
    bilinear.scheme = Scheme::Bilinear;
    std::fill(dropped.face_vertices.begin(), dropped.face_vertices.end(), 0);
    Scene empty;
    const std::uint64_t nothing = Renderer().render(empty, kCamera, kSmall).checksum();
    for (const Cage& cage : {Cage(), without_faces, bilinear, dropped}) {
        Scene scene;
        place(scene, scene.add(demanded(calls, cage)), {0, 0, 0});
        EXPECT_EQ(Renderer().render(scene, kCamera, kSmall).checksum(), nothing);
    }
    EXPECT_GE(calls, 4);
}

TEST(OnDemandCages, SayInTheFrameWhatWasRepaired)
{
    std::atomic<int> calls = 0;
    Cage broken = torus();
    broken.face_vertices[5] = 1000000;
    std::vector<std::string> lines;
    for (std::string& line : sanitize(*std::make_unique<Cage>(broken))) lines.push_back("demanded: " + line);
    ASSERT_FALSE(lines.empty());
    const Camera camera = Camera::look_at({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.6f);
    Scene scene;
    OnDemandCage second = demanded(calls, broken);
    second.name = "second";
    place(scene, scene.add(demanded(calls, broken)), {0, 0, 0});
    const NodeId other = place(scene, scene.add(second), {0.2, 0, 0});
    std::vector<std::string> both = lines;
    for (const std::string& line : lines) both.push_back("second" + line.substr(line.find(':')));
    Renderer renderer;
    for (int frame = 0; frame < 3; ++frame) {
        renderer.render(scene, camera, kSmall);
        EXPECT_EQ(renderer.stats().warnings, both) << "frame " << frame;
        EXPECT_EQ(renderer.stats().scene.warnings, both.size());
    }
    EXPECT_TRUE(scene.warnings.empty()) << "a renderer writes nothing to the scene";

    Settings strict = kSmall;
    strict.strict = true;
    for (Renderer fresh; Renderer * r : {&renderer, &fresh}) EXPECT_THROW(r->render(scene, camera, strict), Error);
    std::ostringstream out;
    EXPECT_THROW(Renderer().replay(scene, camera, strict, {32, 24, 0}, out), Error);

    scene.remove(scene.node(other).cages[0]);
    renderer.render(scene, camera, kSmall);
    EXPECT_EQ(renderer.stats().warnings, lines) << "those of a removed cage are gone";
    Scene sound;
    place(sound, sound.add(demanded(calls, torus())), {0, 0, 0});
    EXPECT_NO_THROW(renderer.render(sound, camera, strict));
    EXPECT_TRUE(renderer.stats().warnings.empty());
}

TEST(OnDemandCages, NeedBoundsThatAreNumbers)
{
    std::atomic<int> calls = 0;
    Scene scene;
    for (const bool is_low : {false, true}) {
        OnDemandCage cage = demanded(calls, torus());
        (is_low ? cage.bounds.lo : cage.bounds.hi).y = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(scene.add(cage), Error);
    }
}

TEST(OnDemandCages, NeedBoundsThatHoldAPoint)
{
    std::atomic<int> calls = 0;
    Scene scene;
    OnDemandCage cage = demanded(calls, torus());
    cage.bounds = {};
    EXPECT_THROW(scene.add(cage), Error);
    for (int axis = 0; axis < 3; ++axis) {
        cage = demanded(calls, torus());
        std::swap(cage.bounds.lo[axis], cage.bounds.hi[axis]);
        EXPECT_THROW(scene.add(cage), Error);
    }
    cage.bounds = {Vec3d(1), Vec3d(1)};
    EXPECT_NO_THROW(scene.add(cage)) << "a point is no empty box";
    EXPECT_EQ(scene.counts().cages, 1u);
}

}  // namespace
}  // namespace occam
