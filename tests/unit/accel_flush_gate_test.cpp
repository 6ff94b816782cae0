// Tests of the gate through which workers drop the data that they share: one that works alone is alone.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "accel/flush_gate.h"

namespace occam::accel {
namespace {

TEST(FlushGate, LetsNoOtherWorkerInWhileOneWorksAlone)
{
    constexpr int kWorkers = 3, kTurns = 40;
    FlushGate gate;
    std::atomic<int> inside = 0, drops = 0, disturbed = 0;
    const auto work_alone = [&] {
        for (int k = 0; k < 5; ++k) {
            disturbed += inside.load() != 0;
            std::this_thread::yield();
        }
        return true;
    };
    std::vector<std::thread> workers;
    for (int w = 0; w < kWorkers; ++w)
        workers.emplace_back([&] {
            const FlushGate::Inside here(&gate);
            for (int turn = 0; turn < kTurns; ++turn) {
                gate.pass();
                ++inside;
                std::this_thread::yield();
                --inside;
                if (turn % 5 == 0 && !gate.alone([&] { ++drops; }, work_alone)) ++disturbed;
            }
        });
    for (std::thread& worker : workers) worker.join();
    EXPECT_EQ(disturbed, 0);
    EXPECT_EQ(drops, kWorkers * kTurns / 5);
    EXPECT_EQ(gate.flushes(), std::uint64_t(drops));
}

TEST(FlushGate, IsUsableAfterWorkThatFails)
{
    FlushGate gate;
    const FlushGate::Inside here(&gate);
    EXPECT_THROW(gate.alone([] {}, []() -> bool { throw Cancelled(); }), Cancelled);
    gate.pass();
    EXPECT_TRUE(gate.alone([] {}, [] { return true; }));
    EXPECT_EQ(gate.flushes(), 2u);
}

}  // namespace
}  // namespace occam::accel
