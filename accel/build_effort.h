// Tells a frame that goes on from one that would not end: one whose memory budget is used up again and again by what a few
// rays meet, so that nearly everything is built anew for each of them. A displacement that is much steeper than its surface
// is wide does this, for example. A query counts nothing: each ray ends, and the application decides how many it asks about.
//
// Threads  add_rays(): any. Everything else: while no ray is traced.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace occam::accel {

class BuildEffort {
public:
    /// Nothing is hopeless before so much was dropped, and as often.
    static constexpr std::uint64_t kLeastBytes = std::uint64_t(6) << 30;
    static constexpr int kLeastFlushes = 4;
    /// What rays may cost on average from the first flush on. All attempts of a ray count (Tracer::State::within_budget).
    static constexpr std::uint64_t kMostBytesARay = std::uint64_t(2) << 20;

    /// Counts rays that have ended.
    void add_rays(std::size_t count) noexcept
    {
        if (flushes_ > 0) rays_.fetch_add(count, std::memory_order_relaxed);
    }
    /// Counts that so many bytes are dropped.
    void add_flush(std::size_t bytes) noexcept
    {
        ++flushes_;
        bytes_ += bytes;
    }
    bool is_hopeless() const noexcept
    {
        return flushes_ >= kLeastFlushes && bytes_ >= kLeastBytes && bytes_ / kMostBytesARay > rays_.load();
    }
    std::uint64_t bytes() const noexcept { return bytes_; }
    std::uint64_t rays() const noexcept { return rays_.load(); }

private:
    std::atomic<std::uint64_t> rays_ = 0;
    std::uint64_t bytes_ = 0;
    int flushes_ = 0;
};

}  // namespace occam::accel
