// Tests of signals while something is made that is worth keeping.
#include "command/interrupt.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/support/child_process.h"

namespace occam::command {
namespace {

constexpr int kLives = 7, kWasSlow = 8;

/// Raises two signals in a process of its own, `apart` from each other, while it holds interrupts. Returns its exit code.
int exit_after_two(std::chrono::milliseconds apart)
{
    const pid_t child = fork();
    if (child == 0) {
        test::end_by_signals();
        catch_interrupts();
        const HeldInterrupts held;
        const auto start = std::chrono::steady_clock::now();
        std::raise(SIGTERM);
        if (!is_interrupted()) _exit(1);
        if (apart.count() > 0) std::this_thread::sleep_for(apart);
        const auto before_second = std::chrono::steady_clock::now() - start;
        std::raise(SIGINT);
        // A machine that is busy may let more time pass than was asked for.
        _exit(apart.count() == 0 && before_second > std::chrono::milliseconds(50) ? kWasSlow : kLives);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Interrupts, ASecondSignalEndsTheProcess)
{
    EXPECT_EQ(exit_after_two(std::chrono::milliseconds(150)), kInterruptedExit);
}

// Programs such as timeout send a signal to the process and to its group.
TEST(Interrupts, ASignalThatIsSentTwiceAtOnceCountsOnce)
{
    int code = kWasSlow;
    for (int round = 0; round < 100 && (code == kWasSlow || code == kInterruptedExit); ++round)
        code = exit_after_two(std::chrono::milliseconds(0));
    EXPECT_EQ(code, kLives);
}

}  // namespace
}  // namespace occam::command
