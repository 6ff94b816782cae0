// Tests of frames that are made in rounds over the whole picture, stopped, and continued.
#include <gtest/gtest.h>

#include <signal.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "base/machine_memory.h"
#include "occam/occam.h"
#include "render/frame_sums.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"
#include "tests/support/shape_builders.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

render::AovSet all_layers()
{
    render::AovSet all;
    for (const render::AovRow& row : render::kAovs) all |= row.aov;
    return all;
}

struct ProgressiveScene {
    Scene scene = builtin_scene();
    Camera camera = scene.camera().value_or(Camera::framing(scene.bounds()));
    Settings settings{.width = test::is_long() ? 50 : 30,
                      .height = test::is_long() ? 34 : 20,
                      .spp = 24,
                      .shutter = {-0.25, 0.25},
                      .aovs = all_layers()};
};

void expect_same(const Image& a, const Image& b)
{
    ASSERT_EQ(a.layers().size(), b.layers().size());
    for (std::size_t i = 0; i < a.layers().size(); ++i) {
        const auto &p = a.layers()[i].pixels, &q = b.layers()[i].pixels;
        ASSERT_EQ(p.size(), q.size());
        EXPECT_EQ(std::memcmp(p.data(), q.data(), p.size() * sizeof(float)), 0) << a.layers()[i].name;
    }
}

TEST(Progressive, RoundsHaveTheBitsOfTiles)
{
    ProgressiveScene subject;
    for (const float error : {0.0f, 0.2f}) {
        subject.settings.error = error;
        subject.settings.progressive = false;
        const Image tiles = Renderer({.threads = 2}).render(subject.scene, subject.camera, subject.settings);
        subject.settings.progressive = true;
        Renderer renderer({.threads = 1});
        expect_same(renderer.render(subject.scene, subject.camera, subject.settings), tiles);
        EXPECT_TRUE(renderer.stats().complete);
        EXPECT_EQ(renderer.stats().image.least_samples, subject.settings.spp);
    }
}

// The first runs are too short for a single sample; the later ones stop anywhere.
TEST(Progressive, APictureOfManyShortRunsHasTheBitsOfOne)
{
    ProgressiveScene subject;
    subject.settings.error = 0.1f;
    Renderer at_once;
    const Image whole = at_once.render(subject.scene, subject.camera, subject.settings);
    std::string checkpoint;
    int runs = 0;
    for (double seconds = 0.002;; seconds *= 1.3) {
        subject.settings.deadline_s = seconds;
        Renderer renderer({.threads = 1 + runs % 2});
        Job job = renderer.start(subject.scene, subject.camera, subject.settings, std::move(checkpoint));
        job.wait();
        checkpoint = job.checkpoint();
        ++runs;
        EXPECT_EQ(checkpoint.empty(), job.stats().complete);
        if (!checkpoint.empty()) continue;
        expect_same(job.image(), whole);
        EXPECT_EQ(job.stats().image.samples, at_once.stats().image.samples) << "those of all runs";
        break;
    }
    EXPECT_GT(runs, 2);
}

// Renders in rounds and stops after so many samples a pixel, of 4,096.
Job stopped_after(int samples, ProgressiveScene& subject)
{
    subject.settings.spp = 4096;
    subject.settings.progressive = true;
    Renderer renderer({.threads = 2});
    Job job = renderer.start(subject.scene, subject.camera, subject.settings);
    while (!(job.progress().fraction > samples / 4096.0)) job.wait_for(1ms);
    job.cancel();
    return job;
}

TEST(Progressive, WhatIsStoppedHasNearlyAsManySamplesEverywhere)
{
    ProgressiveScene subject;
    const Job job = stopped_after(5, subject);
    EXPECT_FALSE(job.stats().complete);
    EXPECT_GE(job.stats().image.least_samples, 4) << "the round of five samples a pixel begins with four everywhere";
}

// The picture was made tile by tile, so that nothing could go on from it.
TEST(Progressive, SumsThatExceedTheMemoryBudgetAreTakenAllTheSame)
{
    ProgressiveScene subject;
    subject.settings.width = 100;
    subject.settings.height = 60;
    subject.settings.spp = 4096;
    subject.settings.progressive = true;
    const std::size_t budget = Renderer({.threads = 1}).memory_floor(subject.scene);
    ASSERT_GT(render::FrameSums::bytes_for(subject.settings), budget);
    Renderer renderer({.threads = 1, .memory_bytes = budget});
    Job job = renderer.start(subject.scene, subject.camera, subject.settings);
    // Tile by tile nothing would be done for minutes.
    for (int i = 0; i < 10'000 && !(job.progress().fraction > 0); ++i) job.wait_for(1ms);
    job.cancel();
    EXPECT_FALSE(job.stats().complete);
    EXPECT_FALSE(job.checkpoint().empty());
}

TEST(Progressive, SumsThatExceedTheMachinesMemoryAreRefused)
{
    const Settings with_deadline{.width = 1 << 14, .height = 1 << 14, .spp = 1, .deadline_s = 1};
    const Settings in_rounds{.width = 1 << 14, .height = 1 << 14, .spp = 1, .progressive = true};
    if (render::FrameSums::bytes_for(in_rounds) * 2 <= machine_memory_bytes() / 4 * 3)
        GTEST_SKIP() << "this machine has room for the sums of the largest picture";
    Scene scene;
    for (const Settings& largest : {with_deadline, in_rounds}) try {
            Renderer renderer({.threads = 1});
            renderer.start(scene, Camera(), largest).image();
            ADD_FAILURE() << "it was made";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), Error::Kind::Output);
            EXPECT_NE(std::string(error.what()).find("for the sums of its pixels"), std::string::npos) << error.what();
        }
}

TEST(Progressive, LayersThatExceedTheMachinesMemoryAreRefused)
{
    Settings settings{.width = 24, .height = 16, .spp = 1, .shutter = {-0.25, 0.25}, .aovs = all_layers()};
    Scene scene;
    Renderer renderer({.threads = 1});
    const Image image = renderer.render(scene, Camera(), settings);
    std::size_t bytes = 0;
    for (const Layer& layer : image.layers()) bytes += layer.pixels.size() * sizeof(float);
    EXPECT_EQ(renderer.stats().memory.film_bytes, bytes);
    settings.width = settings.height = 1 << 14;
    if (bytes / (24 * 16) << 28 <= machine_memory_bytes() / 4 * 3)
        GTEST_SKIP() << "this machine has room for all layers of the largest picture";
    try {
        renderer.render(scene, Camera(), settings);
        ADD_FAILURE() << "it was made";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), Error::Kind::Output);
        EXPECT_NE(std::string(error.what()).find("for its layers"), std::string::npos) << error.what();
    }
}

TEST(Progressive, ACheckpointOfAnotherPictureOrADamagedOneIsRefused)
{
    ProgressiveScene subject;
    subject.settings.deadline_s = 1e-9;
    Renderer renderer;
    const std::string good = renderer.start(subject.scene, subject.camera, subject.settings).checkpoint();
    ASSERT_FALSE(good.empty());
    subject.settings.deadline_s = 0;
    const auto is_refused = [&](const std::string& checkpoint) {
        const Job job = renderer.start(subject.scene, subject.camera, subject.settings, checkpoint);
        EXPECT_THROW(job.image(), Error) << checkpoint.size() << " bytes";
    };
    is_refused("x");
    is_refused(good.substr(0, 20));
    is_refused(good.substr(0, good.size() - 1));
    is_refused(good + "x");
    for (const std::size_t place : {std::size_t(3), std::size_t(25), good.size() / 2, good.size() - 1}) {
        std::string damaged = good;
        damaged[place] = static_cast<char>(damaged[place] ^ 4);
        is_refused(damaged);
    }
    for (const auto change :
         {+[](ProgressiveScene& s) { s.settings.seed = 1; }, +[](ProgressiveScene& s) { s.settings.width = 49; },
          +[](ProgressiveScene& s) { s.settings.aovs = Aov::Depth; }, +[](ProgressiveScene& s) { s.settings.bounces = 3; },
          +[](ProgressiveScene& s) { s.camera.lens.fov *= 1.01f; },
          +[](ProgressiveScene& s) { s.scene.set_transform(s.scene.root(), Trs{.scale = Vec3d(1.001)}); },
          +[](ProgressiveScene& s) {
              s.scene.record_shutter(1, [&](double tau) {
                  s.scene.set_transform(s.scene.root(), Trs{.translation = {tau - 0.5, 0, 0}});
              });
          }}) {
        ProgressiveScene other;
        change(other);
        const Job job = renderer.start(other.scene, other.camera, other.settings, good);
        EXPECT_THROW(job.image(), Error);
    }
    ProgressiveScene same;
    EXPECT_TRUE(renderer.start(same.scene, same.camera, same.settings, good).stats().complete);
}

// The layer `id` and the view of faces show slots of handles, which depend on what was added and removed before.
TEST(Progressive, ACheckpointOfTheSameSceneWithOtherNumbersIsRefusedWhereTheyShow)
{
    const auto scene_after = [](int passing_nodes) {
        Scene scene;
        std::vector<NodeId> passing;
        for (int i = 0; i < passing_nodes; ++i) passing.push_back(scene.add_node(scene.root(), {}));
        NodeDesc desc;
        desc.cages = {scene.add(test::textured_square())};
        scene.add_node(scene.root(), desc);
        for (const NodeId id : passing) scene.remove(id);
        return scene;
    };
    Scene plain = scene_after(0), edited = scene_after(5);
    const Camera camera = Camera::framing(plain.bounds());
    Renderer renderer({.threads = 1});
    const auto is_taken = [&](Settings settings, Scene& by) {
        settings.width = settings.height = 8;
        settings.spp = 2;
        settings.deadline_s = 1e-9;
        const std::string checkpoint = renderer.start(plain, camera, settings).checkpoint();
        EXPECT_FALSE(checkpoint.empty());
        settings.deadline_s = 0;
        const Job job = renderer.start(by, camera, settings, checkpoint);
        try {
            return job.stats().complete;
        } catch (const Error&) {
            return false;
        }
    };
    for (const Settings& shows : {Settings{.aovs = Aov::Id}, Settings{.view = View::Face}}) {
        EXPECT_FALSE(is_taken(shows, edited)) << "one node would have two numbers in the picture";
        EXPECT_TRUE(is_taken(shows, plain));
    }
    EXPECT_TRUE(is_taken({.aovs = Aov::Depth}, edited));
    EXPECT_TRUE(is_taken({.view = View::Normal}, edited));
}

// The lights of this scene take so long to gather that the frame is cancelled meanwhile.
TEST(Progressive, APictureThatIsCancelledBeforeItGoesOnIsThatOfTheCheckpoint)
{
    ProgressiveScene subject;
    const LightId lamp = subject.scene.add(Light{"lamp", PointLight{}});
    for (int i = 0; i < 20000; ++i) {
        NodeDesc desc;
        desc.light = lamp;
        desc.place.translation = Vec3d(i % 100, 20, i / 100);
        subject.scene.add_node(subject.scene.root(), desc);
    }
    Job first = stopped_after(1, subject);
    const std::string checkpoint = first.checkpoint();
    Job next = Renderer({.threads = 2}).start(subject.scene, subject.camera, subject.settings, checkpoint);
    next.cancel();
    EXPECT_EQ(next.checkpoint(), checkpoint);
    EXPECT_EQ(next.stats().image.least_samples, first.stats().image.least_samples);
    EXPECT_EQ(next.progress().fraction, first.progress().fraction);
    EXPECT_GE(next.stats().image.samples, 30u * 20u);
    EXPECT_LE(next.stats().image.samples, first.stats().image.samples);
    expect_same(next.image(), first.image());
}

TEST(Progressive, TheProgressOfAPictureThatWasStoppedIsItsShare)
{
    ProgressiveScene subject;
    const Job job = stopped_after(5, subject);
    job.wait();
    EXPECT_EQ(job.progress().stage, Stage::Done);
    EXPECT_EQ(job.progress().seconds_left, 0);
    EXPECT_GT(job.progress().fraction, 5 / 4096.0);
    EXPECT_LT(job.progress().fraction, 1);
    subject.settings.spp = 2;
    Renderer renderer;
    const Job whole = renderer.start(subject.scene, subject.camera, subject.settings);
    whole.wait();
    EXPECT_EQ(whole.progress().fraction, 1);
}

TEST(Progressive, TheProgressGrowsWhileATileIsMade)
{
    ProgressiveScene subject;
    subject.settings.width = subject.settings.height = 8;
    subject.settings.spp = 1 << 16;
    subject.settings.progressive = false;
    Renderer renderer({.threads = 1});
    Job job = renderer.start(subject.scene, subject.camera, subject.settings);
    while (!(job.progress().fraction > 0)) job.wait_for(1ms);
    EXPECT_LT(job.progress().fraction, 0.9);  // the tile is all of the picture
    job.cancel();
    job.wait();
    EXPECT_EQ(job.progress().fraction, 0);  // and it was not finished
}

TEST(Progressive, ACheckpointWithTexturesOfOtherSizesIsRefused)
{
    Scene scene;
    Texture texture;
    texture.width = texture.height = 64;
    for (int i = 0; i < 64 * 64; ++i) texture.pixels.push_back(Vec4f(Vec3f(float(i % 64) / 63), 1));
    Cage square = test::textured_square();
    Material material;
    material.base_color_texture.texture = scene.add(std::move(texture));
    square.materials = {scene.add(material)};
    NodeDesc desc;
    desc.cages = {scene.add(std::move(square))};
    scene.add_node(scene.root(), desc);
    const Camera camera = Camera::framing(scene.bounds());
    const Settings settings{.width = 16, .height = 16, .spp = 4};
    Settings stopped = settings;
    stopped.deadline_s = 1e-9;
    const std::size_t small = 4096;  // of the 64 x 64 texels
    const std::string of_whole = Renderer().start(scene, camera, stopped).checkpoint();
    const std::string of_halved = Renderer({.texture_bytes = small}).start(scene, camera, stopped).checkpoint();
    const auto is_taken = [&](std::size_t texture_bytes, const std::string& checkpoint) {
        Renderer renderer({.texture_bytes = texture_bytes});
        const Job job = renderer.start(scene, camera, settings, checkpoint);
        try {
            return job.stats().complete;
        } catch (const Error&) {
            return false;
        }
    };
    EXPECT_TRUE(is_taken(std::size_t(1) << 30, of_whole));
    EXPECT_TRUE(is_taken(std::size_t(1) << 20, of_whole)) << "nothing is halved";
    EXPECT_TRUE(is_taken(small, of_halved));
    EXPECT_FALSE(is_taken(small, of_whole)) << "the picture would be a mixture";
    EXPECT_FALSE(is_taken(std::size_t(1) << 30, of_halved));
}

using Resume = test::CommandTest;

TEST_F(Resume, AnInterruptedPictureGoesOnAndIsTheSame)
{
    const std::string spp = test::is_long() ? "1000" : "400";
    const auto words = [&](const std::string& name, const std::vector<std::string>& more = {}) {
        std::vector<std::string> all{"render", "triangle.obj", "-o",    name, "--size",     "64x48",
                                     "--exr",  "float",        "--spp", spp,  "--progress", "plain"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    const auto pixels = [&](const char* name) { return render::Image::read(folder / name).layer(0).pixels; };
    const pid_t child = start(words("a.exr", {"--threads", "1", "--checkpoint", "on"}));
    // Before the first sample of all pixels there is nothing to keep, so the test waits for the first per cent.
    for (int i = 0; i < 12000 && !has_begun(test::text_of(folder / "stderr.txt")); ++i) std::this_thread::sleep_for(5ms);
    kill(child, SIGTERM);
    const test::Outcome stopped = finish(child);
    ASSERT_EQ(stopped.exit_code, test::kInterrupted) << stopped.err;
    ASSERT_TRUE(std::filesystem::exists(folder / "a.exr.checkpoint")) << stopped.err;
    EXPECT_NE(stopped.err.find("--resume"), std::string::npos) << stopped.err;
    const auto partly = pixels("a.exr");

    const test::Outcome other = run(words("a.exr", {"--resume", "--seed", "1"}));
    EXPECT_EQ(other.exit_code, test::kBadInput);
    EXPECT_NE(other.err.find("a.exr.checkpoint"), std::string::npos) << other.err;
    const test::Outcome resumed = run(words("a.exr", {"--resume", "--threads", "1"}));
    ASSERT_EQ(resumed.exit_code, test::kDone) << resumed.err;
    EXPECT_NE(resumed.err.find("going on"), std::string::npos) << resumed.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.exr.checkpoint"));
    ASSERT_EQ(run(words("b.exr", {"--resume"})).exit_code, test::kDone);
    EXPECT_EQ(pixels("a.exr"), pixels("b.exr"));
    EXPECT_NE(pixels("a.exr"), partly);

    ASSERT_EQ(run(words("d.exr", {"--deadline", "1e-9"})).exit_code, test::kDone);
    const std::filesystem::path damaged = folder / "d.exr.checkpoint";
    std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) - 1);
    const test::Outcome refused = run(words("d.exr", {"--resume"}));
    EXPECT_EQ(refused.exit_code, test::kBadInput);
    EXPECT_NE(
        refused.err.find("occam: d.exr.checkpoint: is cut off or damaged; without --resume the picture is made anew\n"),
        std::string::npos)
        << refused.err;
    ASSERT_EQ(run(words("c.exr", {"--deadline", "1e-9", "--checkpoint", "off"})).exit_code, test::kDone);
    EXPECT_FALSE(std::filesystem::exists(folder / "c.exr.checkpoint"));
}

}  // namespace
}  // namespace occam
