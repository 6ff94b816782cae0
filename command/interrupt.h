// Handles Ctrl-C, SIGTERM and the end of the terminal.
//
// A signal ends the process at once with exit code 130 and removes its temporary files, unless something is being made that
// is worth keeping: while a HeldInterrupts lives, the first signal is noted, and the process has a second to end by itself,
// or longer where it asks for that. The second signal ends it at once, unless it comes within a tenth of a second: programs
// such as timeout send a signal twice.
#pragma once

namespace occam::command {

inline constexpr int kInterruptedExit = 130;

/// Installs the handlers of SIGINT, SIGTERM and SIGHUP. Those that the process was started to ignore stay ignored: nohup
/// does that with SIGHUP, and a shell with SIGINT for what a script runs in the background.
void catch_interrupts() noexcept;
/// From now on, whoever reads what the process prints may go away: what is printed then is lost, and the process lives.
void outlive_readers() noexcept;
/// Returns true if a signal was noted.
bool is_interrupted() noexcept;
/// Ends the process now, without waiting for threads.
[[noreturn]] void end_interrupted() noexcept;

/// At most one lives at a time.
class HeldInterrupts {
public:
    HeldInterrupts() noexcept;
    /// Sets the limit again: a process that was interrupted ends within a second from now.
    ~HeldInterrupts() noexcept;
    HeldInterrupts(const HeldInterrupts&) = delete;
    HeldInterrupts& operator=(const HeldInterrupts&) = delete;

    /// Until limit(), lets the process go on without a limit after a first signal, be it noted already or not: what is done
    /// now is worth waiting for, and nobody can hold it up as long as he likes.
    void allow_time() noexcept;
    /// From now on the process ends a second after its first signal, or a second from now if that was noted before.
    void limit() noexcept;
};

}  // namespace occam::command
