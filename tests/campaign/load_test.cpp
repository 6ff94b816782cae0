// Tests of what a long-running application does: thousands of frames, many jobs at once, edits from other threads, and a
// query that lives for many frames.
#include <gtest/gtest.h>
#include <malloc.h>
#include <occam/occam.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include "samples/game/game.h"
#include "tests/support/campaign.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

constexpr Settings kTiny{.width = 32, .height = 18, .spp = 1, .shading_rate = 2};

/// The bytes that the program has allocated and not freed. The resident set would also count pages that the allocator keeps
/// for later, and how many it keeps depends on which thread frees what when.
std::size_t allocated_bytes()
{
    const struct mallinfo2 all = mallinfo2();
    return all.uordblks + all.hblkhd;
}

// The capacities of containers may still grow in the first half. In the second half, all of them together may take 64 KiB
// more than at the peak of the first: one leak of 450 bytes a frame would be more.
TEST(Load, FramesOfTheGameTakeNoMoreMemoryAndDoNotDrift)
{
    const int frames = is_long() ? 10'000 : kIsSanitized ? 40 : 300;
    sample::Game game;
    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(64) << 20});
    std::size_t peaks[2] = {0, 0};
    for (int frame = 0; frame < frames; ++frame) {
        const double clock = frame / 30.0;
        game.step(clock);
        const Image image = renderer.render(game.scene(), game.camera(clock), kTiny);
        std::size_t& peak = peaks[2 * frame / frames];
        peak = std::max(peak, allocated_bytes());
        if (frame % (frames / 10) != 0) continue;
        // A renderer that has just been made knows nothing of the frames before.
        Renderer fresh({.threads = 1, .memory_bytes = std::size_t(64) << 20});
        ASSERT_EQ(fresh.render(game.scene(), game.camera(clock), kTiny).checksum(), image.checksum()) << "frame " << frame;
    }
    if (!kIsSanitized) {
        EXPECT_LE(peaks[1], peaks[0] + (std::size_t(1) << 16)) << "bytes in the second half";
    }
}

Scene rings(int n)
{
    Scene scene;
    const CageId ring = scene.add(torus());
    for (int i = 0; i <= n; ++i) place(scene, ring, {1.5 * i, 0.3 * i, -0.4 * i}, 0.6);
    sample::add_surroundings(scene, 12);
    return scene;
}

TEST(Load, SixtyFourJobsAtOnceGiveThePicturesOfOneAfterTheOther)
{
    constexpr int kScenes = 8, kJobs = 64;
    std::vector<Scene> scenes;
    std::vector<std::uint64_t> expected;
    const auto camera_of = [](Scene& scene) { return Camera::framing(scene.bounds()); };
    for (int s = 0; s < kScenes; ++s) {
        scenes.push_back(rings(s));
        expected.push_back(Renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20})
                               .render(scenes.back(), camera_of(scenes.back()), kTiny)
                               .checksum());
    }
    std::vector<Renderer> renderers;
    std::vector<Job> jobs;
    for (int j = 0; j < kJobs; ++j) {
        Scene& scene = scenes[std::size_t(j % kScenes)];
        renderers.emplace_back(Resources{.threads = 1 + j % 2, .memory_bytes = std::size_t(64) << 20});
        jobs.push_back(renderers.back().start(scene, camera_of(scene), kTiny));
    }
    for (int j = 0; j < kJobs; ++j) {
        if (j % 9 == 4) {
            jobs[std::size_t(j)].cancel();  // its picture has black tiles, or none if it was done before
            jobs[std::size_t(j)].wait();
            continue;
        }
        EXPECT_EQ(jobs[std::size_t(j)].image().checksum(), expected[std::size_t(j % kScenes)]) << "job " << j;
    }
}

/// Edits that other threads ask for; the thread that renders makes them between two frames.
class EditQueue {
public:
    using Edit = std::function<void(Scene&)>;
    void push(Edit edit)
    {
        const std::lock_guard guard(mutex_);
        edits_.push_back(std::move(edit));
    }
    /// Makes the edits that wait, in order. Returns how many there were.
    int apply(Scene& scene)
    {
        std::deque<Edit> now;
        {
            const std::lock_guard guard(mutex_);
            now.swap(edits_);
        }
        for (const Edit& edit : now) edit(scene);
        return static_cast<int>(now.size());
    }

private:
    std::mutex mutex_;
    std::deque<Edit> edits_;
};

TEST(Load, ScenesEditedFromAQueueEndAsIfTheEditsWereMadeAtOnce)
{
    const int edits = is_long() ? 3000 : 60;
    Scene scene = rings(3), at_once = rings(3);
    const auto edit_of = [](int k) -> EditQueue::Edit {
        return [k](Scene& s) {
            const NodeId moved = s.node(s.root()).children[1];
            if (k % 3 == 0)
                s.replace(s.node(moved).cages[0], k % 2 ? prism(3 + std::uint32_t(k % 7)) : torus(5 + std::uint32_t(k % 5)));
            else if (k % 3 == 1) s.set_visible(s.node(s.root()).children[2], k % 2 != 0);
            else s.set_transform(moved, {.translation = {0.01 * k, 0.2, 0}});
        };
    };
    EditQueue queue;
    std::thread application([&] {
        for (int k = 0; k < edits; ++k) {
            queue.push(edit_of(k));
            if (k % 4 == 0) std::this_thread::yield();
        }
    });
    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(64) << 20});
    const Camera camera = Camera::framing(at_once.bounds());
    std::uint64_t last = 0;
    for (int made = 0; made < edits;) {
        made += queue.apply(scene);
        last = renderer.render(scene, camera, kTiny).checksum();
    }
    application.join();
    for (int k = 0; k < edits; ++k) edit_of(k)(at_once);
    EXPECT_EQ(Renderer({.threads = 1}).render(at_once, camera, kTiny).checksum(), last);
}

TEST(Load, AQueryLivesThroughFramesOfItsSceneAndEditsOfOthers)
{
    Scene scene = rings(4), other = rings(2);
    const Camera camera = Camera::framing(scene.bounds());
    const NodeId ring = scene.node(scene.root()).children.front();
    Query query(scene, camera, 180);
    std::vector<double> first;
    const auto distances = [&] {
        std::vector<double> all;
        for (int k = 0; k < 200; ++k) {
            const auto hit = query.pick(1.6 * k, 0.9 * k, 320);
            all.push_back(hit ? hit->distance : -1);
        }
        return all;
    };
    first = distances();
    EXPECT_GT(std::count_if(first.begin(), first.end(), [](double d) { return d > 0; }), 20) << "the query sees the scene";
    std::atomic<bool> is_over = false;
    std::thread elsewhere([&] {
        Renderer renderer({.threads = 1, .memory_bytes = std::size_t(64) << 20});
        for (int k = 0; !is_over; ++k) {
            other.set_transform(other.node(other.root()).children.front(), {.translation = {0.01 * k, 0, 0}});
            renderer.render(other, camera, kTiny);
        }
    });
    Renderer renderer({.threads = 2, .memory_bytes = std::size_t(64) << 20});
    const std::uint64_t picture = renderer.render(scene, camera, kTiny).checksum();
    for (int frame = 0; frame < (is_long() ? 1000 : 10); ++frame) {
        EXPECT_EQ(renderer.render(scene, camera, kTiny).checksum(), picture);
        EXPECT_EQ(distances(), first);
        EXPECT_THROW(scene.set_visible(ring, false), Error) << "an edit of what a query looks at";
    }
    is_over = true;
    elsewhere.join();
}

}  // namespace
}  // namespace occam::test
