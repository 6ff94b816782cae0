#include "interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace occam::command {
namespace {

std::atomic<bool> interrupted = false, held = false, is_limited = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler may use no other atomics

extern "C" void note_interrupt(int)
{
    if (interrupted.exchange(true) || !held.load()) _exit(kInterruptedExit);
    if (is_limited.load()) alarm(1);
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

bool is_interrupted() noexcept { return interrupted.load(); }

void end_interrupted() noexcept { _exit(kInterruptedExit); }

HeldInterrupts::HeldInterrupts() noexcept { held.store(true); }

HeldInterrupts::~HeldInterrupts()
{
    is_limited.store(false);
    held.store(false);
}

void HeldInterrupts::limit() noexcept { is_limited.store(true); }

}  // namespace occam::command
