// Scenes and cameras of extreme extent, and frames that would take hours: each ends, and a cancelled frame ends soon.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "occam/occam.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"

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

/// 200,000 cages in one place: each ray meets all of them.
TEST(Cancelling, EndsAFrameInWhichARayMeetsEverything)
{
    Scene scene;
    const CageId cage = scene.add(creased_cube(1));
    for (int k = 0; k < 200'000; ++k) scene.add_node(scene.root(), {.cages = {cage}});
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

/// The tables of a prism over a polygon of 500 corners take ten seconds.
TEST(Cancelling, EndsAFrameWhoseTablesAreInTheMaking)
{
    Scene scene;
    scene.add_node(scene.root(), {.cages = {scene.add(prism(500))}});
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
