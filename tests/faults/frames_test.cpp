// Frames and queries that run out of memory: they end by an error, nothing is lost, and the next ones have the same bits.
#include <gtest/gtest.h>

#include <optional>

#include "occam/occam.h"
#include "tests/faults/fail_everywhere.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/shape_builders.h"
#include "tests/support/textured_floor.h"

namespace occam::test {
namespace {

const Camera kCamera = Camera::look_at({1, 2.5, 5}, {0, 0.3, 0}, {0, 1, 0}, 0.8f);
const Settings kSettings{.width = 16, .height = 12, .spp = 1};

/// Fills a scene with a bit of everything: a textured floor, creased and displaced cages, a mesh, instances, lamps, clear
/// glass, and a sky with a bright spot.
void furnish(Scene& scene)
{
    Material tiles;
    tiles.base_color_texture.texture = scene.add(waves(0));
    tiles.bump_texture.texture = scene.add(waves(1));
    scene.add_node(scene.root(), {.cages = {scene.add(floor_of(scene.add(tiles), Scheme::Triangles))}});
    place(scene, scene.add(prism(5)), {-1, 0.6, 0}, 0.5);
    Material glass;
    glass.transmission = 1;
    glass.roughness = 0;
    Cage ring = torus();
    ring.materials = {scene.add(glass)};
    place(scene, scene.add(std::move(ring)), {1, 0.5, 0}, 0.5);
    place(scene, scene.add(torus_mesh(9, 5)), {0, 0.4, 1.2}, 0.3);
    Cage bumpy = displaced_case(0).cage;
    bumpy.displacement->texture.texture = scene.add(waves(2));
    const NodeId shown = scene.add_node(scene.root(), {.matrix = moved(0, 1, -1), .cages = {scene.add(std::move(bumpy))}});
    scene.add_node(scene.root(), {.matrix = moved(1, 0, 0), .instance_of = shown});
    for (int lamp = 0; lamp < 20; ++lamp) {
        NodeDesc desc;
        desc.place.translation = {0.3 * lamp - 3, 4, 2};
        desc.light = scene.add(Light{"lamp", PointLight{Vec3f(3)}});
        scene.add_node(scene.root(), desc);
    }
    scene.environment.radiance = Vec3f(1);
    scene.environment.image = scene.add(texture_of([](float x, float y) { return Vec4f(x < 3 && y < 3 ? 60.0f : 0.2f); }));
}

class Faults : public testing::Test {
protected:
    void SetUp() override
    {
        if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
    }
};

class FailingFrames : public Faults {};

TEST_F(FailingFrames, EndByAnErrorAndTheNextOneHasTheSameBits)
{
    Scene scene;
    furnish(scene);
    const std::uint64_t wanted = Renderer({.threads = 1}).render(scene, kCamera, kSettings).checksum();
    std::optional<Renderer> renderer;
    fail_everywhere(
        {.dense = 4, .growth = 1.8, .may_lose_blocks = true},  // OpenSubdiv makes the tables of cages anew
        [&] {
            renderer.emplace(Resources{.threads = 1});
            EXPECT_EQ(renderer->render(scene, kCamera, kSettings).checksum(), wanted);
        },
        [&](bool) {
            if (!renderer) renderer.emplace(Resources{.threads = 1});
            EXPECT_EQ(renderer->render(scene, kCamera, kSettings).checksum(), wanted);
            renderer.reset();
        });
}

TEST_F(FailingFrames, KeepWhatTheRendererKnowsFromEarlierOnes)
{
    Scene scene;
    furnish(scene);
    Renderer renderer({.threads = 1});
    const Settings settings{.width = 12, .height = 8, .spp = 2, .aovs = {Aov::Depth, Aov::CryptomatteObject}};
    const std::uint64_t wanted = renderer.render(scene, kCamera, settings).checksum();
    const auto render = [&] { EXPECT_EQ(renderer.render(scene, kCamera, settings).checksum(), wanted); };
    fail_everywhere({.dense = 4, .growth = 1.7}, render, [&](bool) { render(); });
}

// Two workers share a tree that they drop again and again. One of them fails while the other is anywhere.
TEST_F(FailingFrames, OfWorkersThatShareATreeEndForAllOfThem)
{
    Scene scene;
    furnish(scene);
    Resources resources{.threads = 2, .workers_a_tree = 2};
    resources.memory_bytes = Renderer(resources).memory_floor(scene);
    const Settings settings{.width = 40, .height = 32, .spp = 2};
    const std::uint64_t wanted = Renderer({.threads = 1}).render(scene, kCamera, settings).checksum();
    Renderer renderer(resources);
    const auto render = [&] { EXPECT_EQ(renderer.render(scene, kCamera, settings).checksum(), wanted); };
    render();
    fail_everywhere({.dense = 2, .growth = 3}, render, [&](bool) { render(); });
}

TEST_F(FailingFrames, WithMotionBlurEndByAnError)
{
    Scene scene;
    furnish(scene);
    const NodeId mover = scene.add_node(scene.root(), {.cages = {scene.add(torus(5, 4))}});
    const Settings settings{.width = 8, .height = 6, .spp = 1};
    const auto record = [&] { scene.record_shutter(2, [&](double tau) { scene.set_transform(mover, moved(tau, 1, 0)); }); };
    record();
    Renderer renderer({.threads = 1});
    const std::uint64_t wanted = renderer.render(scene, kCamera, settings).checksum();
    const auto render = [&] {
        record();
        EXPECT_EQ(renderer.render(scene, kCamera, settings).checksum(), wanted);
    };
    fail_everywhere({.dense = 4, .growth = 1.6}, render, [&](bool) { render(); });
}

TEST_F(FailingFrames, LeaveQueriesTheirAnswers)
{
    Scene scene;
    furnish(scene);
    Query query(scene, kCamera, 48);
    std::vector<QueryRay> rays;
    for (int i = 0; i < 12; ++i) rays.push_back({{0.2 * i - 1.2, 3, 0.1 * i - 0.5}, {0.1, -1, 0.05}});
    std::vector<FirstHit> wanted(rays.size()), found(rays.size());
    query.first_hits(rays, wanted);
    const auto ask = [&] {
        query.begin(kCamera);
        query.first_hits(rays, found);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const std::optional<Hit> hit = query.closest(rays[i]);
            EXPECT_EQ(found[i].distance, wanted[i].distance);
            EXPECT_EQ(hit ? hit->node : NodeId(), wanted[i].node);
        }
    };
    // OpenSubdiv loses a few blocks where an allocation fails while it makes the surface of a patch.
    fail_everywhere({.dense = 4, .growth = 1.6, .may_lose_blocks = true}, ask, [&](bool) { ask(); });
}

}  // namespace
}  // namespace occam::test
