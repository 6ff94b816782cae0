// Tests that frames which are made at once have the threads that they ask for, also more than there are processors.
#include "render/lent_arena.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "base/processors.h"
#include "occam/occam.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

/// Returns whether so many threads of the arena work at once before half a minute has passed.
bool has_threads(const render::LentArena& arena, int wanted)
{
    std::atomic<int> here = 0;
    const auto end = std::chrono::steady_clock::now() + 30s;
    arena.execute([&] {
        tbb::parallel_for(
            0, wanted,
            [&](int) {
                ++here;
                while (here < wanted && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
            },
            tbb::simple_partitioner());
    });
    return std::chrono::steady_clock::now() < end;
}

TEST(LentArena, HasAllItsThreadsBesideASmallerOne)
{
    const int few = processor_count() + 2, many = processor_count() + 7;
    const render::LentArena small(few);
    const render::LentArena large(many);
    EXPECT_TRUE(has_threads(large, many));
    EXPECT_TRUE(has_threads(small, few));
}

// TBB wrote to the application's standard error where the control of another frame allowed fewer threads.
TEST(LentArena, FramesOfDifferentlyManyThreadsMakeNoNoise)
{
    testing::internal::CaptureStderr();
    Scene scene = builtin_scene(), other = builtin_scene();
    const Camera camera = scene.camera().value_or(Camera::framing(scene.bounds()));
    Renderer few({.threads = processor_count() + 11}), many({.threads = processor_count() + 23});
    Job job = few.start(scene, camera, {.width = 64, .height = 48, .spp = 4096});
    while (!(job.progress().fraction > 0)) job.wait_for(1ms);
    const Image image = many.render(other, camera, {.width = 32, .height = 24, .spp = 1});
    job.cancel();
    job.wait();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(image.checksum(),
              Renderer({.threads = 1}).render(other, camera, {.width = 32, .height = 24, .spp = 1}).checksum());
}

}  // namespace
}  // namespace occam
