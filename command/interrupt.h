// Handles Ctrl-C and SIGTERM.
//
// A signal ends the process at once with exit code 130, unless something is being made that is worth keeping: while a
// HeldInterrupts lives, the first signal is noted and the second one ends the process.
#pragma once

namespace occam::command {

inline constexpr int kInterruptedExit = 130;

/// Installs the handlers of SIGINT and SIGTERM.
void catch_interrupts() noexcept;
/// Returns true if a signal was noted.
bool is_interrupted() noexcept;
/// Ends the process now, without waiting for threads.
[[noreturn]] void end_interrupted() noexcept;

class HeldInterrupts {
public:
    HeldInterrupts() noexcept;
    ~HeldInterrupts();
    HeldInterrupts(const HeldInterrupts&) = delete;
    HeldInterrupts& operator=(const HeldInterrupts&) = delete;
};

}  // namespace occam::command
