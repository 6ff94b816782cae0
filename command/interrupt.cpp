#include "interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace occam::command {
namespace {

std::atomic<bool> held = false, is_limited = false;
std::atomic<std::int64_t> interrupted_at = 0;  // in milliseconds; 0: no signal was noted
// A signal handler may use no other atomics.
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

// Programs such as timeout send a signal twice, to the process and to its group, so one that follows at once is the same.
constexpr std::int64_t kSameSignalMs = 100;

std::int64_t now_ms() noexcept
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t(now.tv_sec) * 1000 + now.tv_nsec / 1'000'000;
}

extern "C" void note_interrupt(int)
{
    if (!held.load()) _exit(kInterruptedExit);
    const std::int64_t now = now_ms();
    std::int64_t first = 0;
    if (interrupted_at.compare_exchange_strong(first, now)) {
        if (is_limited.load()) alarm(1);
    } else if (now - first > kSameSignalMs) {
        _exit(kInterruptedExit);
    }
}

extern "C" void end_at_alarm(int) { _exit(kInterruptedExit); }

}  // namespace

void catch_interrupts() noexcept
{
    struct sigaction action = {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
    action.sa_handler = end_at_alarm;
    sigaction(SIGALRM, &action, nullptr);
}

bool is_interrupted() noexcept { return interrupted_at.load() != 0; }

void end_interrupted() noexcept { _exit(kInterruptedExit); }

HeldInterrupts::HeldInterrupts() noexcept { held.store(true); }

HeldInterrupts::~HeldInterrupts()
{
    is_limited.store(false);
    held.store(false);
}

void HeldInterrupts::limit() noexcept { is_limited.store(true); }

}  // namespace occam::command
