// Adds the time of a scope to a sum of seconds. It is meant for building, which is cold; one use costs 50 ns.
#pragma once

#include <chrono>

namespace occam::accel {

class Stopwatch {
public:
    explicit Stopwatch(double& seconds) noexcept : seconds_(seconds), start_(Clock::now()) {}
    ~Stopwatch() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    using Clock = std::chrono::steady_clock;
    double& seconds_;
    Clock::time_point start_;
};

}  // namespace occam::accel
