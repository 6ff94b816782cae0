// Wall time: the seconds since a moment, and those of a scope.
#pragma once

#include <chrono>

namespace occam {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) noexcept
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Adds the time of a scope to a sum of seconds. It is meant for what takes much longer than the 50 ns that one use costs.
class Stopwatch {
public:
    explicit Stopwatch(double& seconds) noexcept : seconds_(seconds) {}
    ~Stopwatch() { seconds_ += seconds_since(start_); }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    double& seconds_;
    const Clock::time_point start_ = Clock::now();
};

}  // namespace occam
