// How far a frame is, and the word to stop: between the frame and whoever watches it.
//
// Threads  everything from any thread; cancel() from a signal handler too.
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
        double fraction = 0;       ///< of the tiles
        double seconds_left = -1;  ///< an estimate from the tiles so far; below 0: unknown
    };
    Progress progress() const noexcept;

    /// Workers stop after the batch of rays that they are at. Finished tiles stay.
    void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
    bool is_cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }

    // What follows is for the frame itself.
    void enter(Stage stage) noexcept { stage_.store(stage); }
    void start_tiles(std::size_t count) noexcept;
    void finish_tile() noexcept { ++tiles_done_; }
    std::size_t tiles_done() const noexcept { return tiles_done_; }
    double fraction_done() const noexcept { return tiles_ == 0 ? 0 : double(tiles_done_) / double(tiles_); }

private:
    using Clock = std::chrono::steady_clock;
    std::atomic<bool> cancelled_ = false;
    std::atomic<Stage> stage_ = Stage::Waiting;
    std::atomic<std::size_t> tiles_ = 0, tiles_done_ = 0;
    std::atomic<Clock::time_point> start_ = Clock::time_point{};
};

}  // namespace occam::render
