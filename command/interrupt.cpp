#include "interrupt.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>

#include "io/open_temporaries.h"

namespace occam::command {
namespace {

std::atomic<bool> held = false;
std::atomic<bool> has_time = false;            // the limit that the first signal sets is lifted
std::atomic<std::int64_t> interrupted_at = 0;  // in milliseconds; 0: no signal was noted
// A signal handler may use no other atomics.
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

// Programs such as timeout send a signal twice, to the process and to its group, so one that follows at once is the same.
constexpr std::int64_t kSameSignalMs = 100;
constexpr unsigned kLimitSeconds = 1;

std::int64_t now_ms() noexcept
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t(now.tv_sec) * 1000 + now.tv_nsec / 1'000'000;
}

extern "C" void note_interrupt(int)
{
    if (!held.load()) end_interrupted();
    const int error = errno;  // of the call that is interrupted
    const std::int64_t now = now_ms();
    std::int64_t first = 0;
    // Whatever the process waits for, it does not wait for it for ever.
    if (interrupted_at.compare_exchange_strong(first, now)) alarm(kLimitSeconds);
    else if (now - first > kSameSignalMs) end_interrupted();
    errno = error;
}

extern "C" void end_at_alarm(int)
{
    if (!has_time.load()) end_interrupted();
}

}  // namespace

void catch_interrupts() noexcept
{
    struct sigaction action = {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction of_caller = {};
        sigaction(signal, nullptr, &of_caller);
        if (of_caller.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
    }
    action.sa_handler = end_at_alarm;
    sigaction(SIGALRM, &action, nullptr);
    sigset_t alarm_alone;  // a process may be started with signals blocked
    sigemptyset(&alarm_alone);
    sigaddset(&alarm_alone, SIGALRM);
    pthread_sigmask(SIG_UNBLOCK, &alarm_alone, nullptr);
}

void outlive_readers() noexcept { std::signal(SIGPIPE, SIG_IGN); }

bool is_interrupted() noexcept { return interrupted_at.load() != 0; }

void end_interrupted() noexcept
{
    remove_open_temporaries();
    _exit(kInterruptedExit);
}

HeldInterrupts::HeldInterrupts() noexcept { held.store(true); }

HeldInterrupts::~HeldInterrupts() noexcept
{
    limit();
    held.store(false);
}

void HeldInterrupts::allow_time() noexcept { has_time.store(true); }

void HeldInterrupts::limit() noexcept
{
    has_time.store(false);
    if (is_interrupted()) alarm(kLimitSeconds);
}

}  // namespace occam::command
