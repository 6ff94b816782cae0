// Tests the threads that are kept: that all parts of some work are made, by as many threads as asked for, or by fewer where
// the system refuses them; and that neither these nor the caller's rounding change a picture.
#include "base/threads.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <xmmintrin.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "base/processors.h"
#include "occam/occam.h"
#include "tests/support/other_floats.h"

namespace occam {
namespace {

using namespace std::chrono_literals;

/// Returns whether so many parts run at once before half a minute has passed.
bool run_at_once(int wanted)
{
    std::atomic<int> here = 0;
    const auto end = std::chrono::steady_clock::now() + 30s;
    run_in_threads(wanted, [&](int) {
        ++here;
        while (here < wanted && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
    });
    return std::chrono::steady_clock::now() < end;
}

// Lets the system refuse threads while it lives: none has room for such a stack.
class NoThreads {
public:
    NoThreads()
    {
        pthread_getattr_default_np(&before_);
        pthread_attr_t huge;
        pthread_attr_init(&huge);
        pthread_attr_setstacksize(&huge, std::size_t(1) << 50);
        pthread_setattr_default_np(&huge);
        pthread_attr_destroy(&huge);
    }
    ~NoThreads() { pthread_setattr_default_np(&before_); }
    NoThreads(const NoThreads&) = delete;
    NoThreads& operator=(const NoThreads&) = delete;

private:
    pthread_attr_t before_;
};

// The functions of <cfenv> tell of a unit that computes no floats.
bool rounds_to_nearest()
{
    volatile float one = 1, little = 1e-9f;
    return one + little == one && -one - little == -one;
}
bool has_denormals()
{
    volatile float smallest = std::numeric_limits<float>::min();
    return smallest * 0.5f > 0;
}

TEST(Threads, RunEachPartOnce)
{
    for (const int count : {0, 1, 2, 7, 100}) {
        std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
        run_in_threads(count, [&](int part) { ++runs[static_cast<std::size_t>(part)]; });
        for (const auto& of_part : runs) EXPECT_EQ(of_part, 1);
    }
}

TEST(Threads, AreAsManyAsAskedForAlsoBesideOthers)
{
    const int few = processor_count() + 2, many = processor_count() + 7;
    EXPECT_TRUE(run_at_once(many));
    EXPECT_TRUE(run_at_once(few));
    std::atomic<bool> has_few = false, has_many = false;
    {
        const std::jthread other([&] { has_few = run_at_once(few); });
        has_many = run_at_once(many);
    }
    EXPECT_TRUE(has_few);
    EXPECT_TRUE(has_many);
}

TEST(Threads, PassOnWhatAPartThrowsAndWorkAfterwards)
{
    for (int i = 0; i < 20; ++i) {
        std::atomic<int> ended = 0;
        const auto work = [&](int part) {
            if (part == 1) throw std::runtime_error("part 1");
            ++ended;
        };
        EXPECT_THROW(run_in_threads(3, work), std::runtime_error);
        EXPECT_LE(ended, 2);
        ended = 0;
        run_in_threads(3, [&](int) { ++ended; });
        EXPECT_EQ(ended, 3);
    }
}

TEST(Threads, ThatTheSystemRefusesAreDoneWithout)
{
    const NoThreads refused;
    EXPECT_THROW(std::thread([] {}).join(), std::system_error);
    std::atomic<int> ended = 0;
    run_in_threads(processor_count() + 300, [&](int) { ++ended; });
    EXPECT_EQ(ended, processor_count() + 300);
}

TEST(Threads, ComputeWithDefaultFloats)
{
    const test::OtherFloats others;
    EXPECT_FALSE(rounds_to_nearest() || has_denormals()) << "this thread computes otherwise";
    const unsigned before = _mm_getcsr();
    std::atomic<int> right = 0;
    run_in_threads(4, [&](int) { right += rounds_to_nearest() && has_denormals(); });
    EXPECT_EQ(right, 4);
    EXPECT_EQ(_mm_getcsr(), before);
}

struct FramesOfThreads : testing::Test {
    Image frame(int threads) { return Renderer({.threads = threads}).render(scene, camera, settings); }
    Scene scene = builtin_scene();
    Camera camera = scene.camera().value_or(Camera::framing(scene.bounds()));
    Settings settings{.width = 32, .height = 24, .spp = 1};
};

TEST_F(FramesOfThreads, HaveTheSameBitsWhateverTheApplicationsRounding)
{
    const std::uint64_t expected = frame(1).checksum();
    const test::OtherFloats others;
    EXPECT_EQ(frame(1).checksum(), expected);
    EXPECT_EQ(frame(3).checksum(), expected);
}

TEST_F(FramesOfThreads, NeedNoThreadOfTheirOwn)
{
    const std::uint64_t expected = frame(2).checksum();
    const NoThreads refused;
    EXPECT_EQ(frame(processor_count() + 400).checksum(), expected);
    Renderer renderer({.threads = 2});
    try {
        renderer.start(scene, camera, settings);
        ADD_FAILURE() << "a frame has started without a thread";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), Error::Kind::Output);
        EXPECT_NE(std::string(error.what()).find("no thread"), std::string::npos) << error.what();
    }
    EXPECT_EQ(renderer.render(scene, camera, settings).checksum(), expected);  // the renderer is free again
}

// Frames of different numbers of threads are made at once.
TEST_F(FramesOfThreads, MakeNoNoiseBesideEachOther)
{
    testing::internal::CaptureStderr();
    Scene other = builtin_scene();
    Renderer few({.threads = processor_count() + 11}), many({.threads = processor_count() + 23});
    Job job = few.start(scene, camera, {.width = 64, .height = 48, .spp = 256});
    while (!(job.progress().fraction > 0)) job.wait_for(1ms);
    const Image image = many.render(other, camera, settings);
    job.cancel();
    job.wait();
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(image.checksum(), Renderer({.threads = 1}).render(other, camera, settings).checksum());
}

}  // namespace
}  // namespace occam
