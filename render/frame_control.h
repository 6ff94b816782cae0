// The progress of a frame and the request to cancel it, shared by the frame and its observers.
//
// Threads  any thread may call everything; a signal handler may call cancel().
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>

namespace occam::render {

class FrameControl {
public:
    enum class Stage : unsigned char { Waiting, Preparing, Rendering, Done };

    struct Progress {
        Stage stage = Stage::Waiting;
        /// Share of the samples that are done, or made for tiles that are not finished. After a frame was stopped it counts
        /// only those that are done and stays below 1: Stage::Done says that the frame ended.
        double fraction = 0;
        double seconds_left = -1;  ///< an estimate from the samples so far; below 0: unknown
    };
    Progress progress() const noexcept;

    /// Asks the workers to stop after the batch of rays that they are working on. Finished tiles stay.
    void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
    bool is_cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

    // The following functions are for the frame itself.
    void enter(Stage stage) noexcept { stage_.store(stage); }
    /// samples   number in all tiles, counting one pixel of each
    /// done      how many of these an earlier run has made
    void start_samples(std::size_t samples, std::size_t done) noexcept;
    void finish_samples(std::size_t count) noexcept { done_ += count; }
    /// Counts samples that are made as long as their tiles are not finished.
    class Unfinished {
    public:
        explicit Unfinished(FrameControl& control) noexcept : control_(control) {}
        ~Unfinished() { control_.unfinished_ -= count_; }
        Unfinished(const Unfinished&) = delete;
        Unfinished& operator=(const Unfinished&) = delete;
        void add(std::size_t count) noexcept
        {
            count_ += count;
            control_.unfinished_ += count;
        }

    private:
        FrameControl& control_;
        std::size_t count_ = 0;
    };
    bool is_whole() const noexcept { return done_ == samples_; }

private:
    using Clock = std::chrono::steady_clock;
    std::atomic<bool> cancelled_ = false;
    std::atomic<Stage> stage_ = Stage::Waiting;
    std::atomic<std::size_t> samples_ = 0, done_ = 0, unfinished_ = 0, done_before_ = 0;
    std::atomic<Clock::time_point> start_ = Clock::time_point{};
};

}  // namespace occam::render
