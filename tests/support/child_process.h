// Runs the executable `occam` as a child process, and measures what it used.
#pragma once

#include <string>
#include <vector>

namespace occam::test {

struct ChildOutcome {
    int exit_code = -1;          ///< -1: ended by a signal
    int signal = 0;              ///< SIGALRM: it ran into the time limit
    std::size_t peak_bytes = 0;  ///< largest resident size
    double seconds = 0;
    std::string err;  ///< its standard error output
};

/// Returns the path of the executable `occam` that belongs to these tests.
const char* occam_executable();
/// Returns the path of the same executable whose allocations can fail (tests/faults/fail_by_environment.cpp).
const char* failing_executable();

/// Makes SIGHUP, SIGINT and SIGTERM end a new process, even if the tests themselves were started with these signals
/// ignored, as a script starts its background jobs.
void end_by_signals() noexcept;

/// Runs the executable to its end, or for `limit_s` seconds. Throws std::runtime_error if it cannot be started.
ChildOutcome run_occam(const std::vector<std::string>& arguments, unsigned limit_s);

}  // namespace occam::test
