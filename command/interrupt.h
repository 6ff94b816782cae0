// Handles Ctrl-C and SIGTERM.
//
// A signal ends the process at once with exit code 130, unless something is being made that is worth keeping: while a
// HeldInterrupts lives, the first signal is noted and the second one ends the process, unless it comes within a tenth of a
// second: programs such as timeout send a signal twice. While a file is written, which cannot look for signals, the first
// one ends the process a second later; the file then keeps what it held before.
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
    /// From now on the process ends a second after its first signal. A signal that was noted before has no such limit: what
    /// is written then is what was worth keeping.
    void limit() noexcept;
    HeldInterrupts(const HeldInterrupts&) = delete;
    HeldInterrupts& operator=(const HeldInterrupts&) = delete;
};

}  // namespace occam::command
