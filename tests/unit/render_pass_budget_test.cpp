// Tests of the limit on the surfaces that the rays of a frame pass straight on.
#include <gtest/gtest.h>
#include <occam/occam.h>

#include <thread>

#include "render/pass_budget.h"

namespace occam {
namespace {

constexpr int kWidth = 48, kHeight = 32;

Cage quads(std::uint32_t count, float half, float step)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const float y = float(i) * step;
        cage.positions.insert(cage.positions.end(),
                              {{-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}});
        for (const std::uint32_t corner : {0, 2, 1, 0, 3, 2}) cage.face_vertices.push_back(4 * i + corner);
    }
    return cage;
}

// Renders a row of panes that nobody sees over a floor. The camera or a lamp looks along it. Returns the error, if there is
// one.
std::string refusal_of(std::uint32_t panes, bool by_lamp, int threads)
{
    Scene scene;
    Material clear;
    clear.alpha_mode = AlphaMode::Blend;
    clear.base_color = Vec4f(1, 1, 1, 0);
    Cage row = quads(panes, 0.5f, 8.0f / float(panes));
    row.materials = {scene.add(clear)};
    scene.add_node(scene.root(), {.place = {.translation = {0, -1, 0}}, .cages = {scene.add(quads(1, 0.5f, 0))}});
    const NodeId node = scene.add_node(scene.root(), {.cages = {scene.add(std::move(row))}});
    scene.set_seen_by(node, by_lamp ? RayKind::Shadow : RayKind::Camera);
    NodeDesc lamp;
    lamp.place.translation = {0, 100, 0};
    lamp.light = scene.add(Light{"lamp", PointLight{Vec3f(1e4f)}});
    scene.add_node(scene.root(), lamp);
    const Camera camera = Camera::look_at({0, 100, 0}, {0, 0, 0}, {0, 0, -1}, 0.006f);
    try {
        Renderer({.threads = threads})
            .render(scene, camera,
                    {.width = kWidth,
                     .height = kHeight,
                     .spp = 1,
                     .integrator = IntegratorKind::Direct,
                     .sky = shade::Sky::Off});
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(PassBudget, AFrameEndsWhoseRaysPassTooManySurfacesThatAreFewByTheirAreas)
{
    const auto most = static_cast<std::uint32_t>(render::PassBudget::kLeast / (kWidth * kHeight));
    for (const bool by_lamp : {false, true}) {
        EXPECT_NE(refusal_of(most + most / 8, by_lamp, 2).find("one behind the other"), std::string::npos) << by_lamp;
        EXPECT_EQ(refusal_of(most - most / 8, by_lamp, 1), "") << by_lamp;
    }
}

TEST(PassBudget, CountsTheSurfacesOfAllThreadsAndGrowsWithTheSamples)
{
    const auto limit_of = [](const Settings& settings) {
        return std::max(double(render::PassBudget::kLeast), render::PassBudget::kMostOfASample * settings.width *
                                                                settings.height * settings.spp * settings.light_samples);
    };
    for (const Settings& settings :
         {Settings{.width = 4, .height = 4, .spp = 1}, Settings{.width = 640, .height = 480, .spp = 16},
          Settings{.width = 64, .height = 48, .spp = 4, .light_samples = 8}}) {
        render::PassBudget budget(settings);
        const auto most = static_cast<std::uint64_t>(limit_of(settings));
        std::vector<std::thread> threads;
        for (int i = 0; i < 4; ++i)
            threads.emplace_back([&] { EXPECT_NO_THROW(for (int k = 0; k < 16; ++k) budget.spend(most / 64)); });
        for (std::thread& thread : threads) thread.join();
        EXPECT_NO_THROW(budget.spend(0));
        EXPECT_THROW(budget.spend(1), Error);
    }
}

}  // namespace
}  // namespace occam
