// The crowd in Embree 3: subdivision surfaces tessellated by edge levels, rebuilt every frame, traced in packets of eight.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>

#include "tests/bench/crowd.h"

namespace occam::bench {

class EmbreeCrowd {
public:
    /// Makes a robust device and scene with Embree's fastest dynamic settings (RTC_BUILD_QUALITY_LOW,
    /// RTC_SCENE_FLAG_DYNAMIC).
    explicit EmbreeCrowd(const Crowd& crowd);
    ~EmbreeCrowd();
    EmbreeCrowd(const EmbreeCrowd&) = delete;
    EmbreeCrowd& operator=(const EmbreeCrowd&) = delete;

    struct Frame {
        double edit_seconds = 0, commit_seconds = 0, trace_seconds = 0;
        std::uint64_t rays = 0;
        double mean_luminance = 0;
    };
    /// Sets new vertices and edge levels, commits, and traces every ray of the recipe, on all processors.
    Frame render(int frame, const Recipe& recipe);

    std::size_t bytes() const noexcept { return bytes_; }
    std::size_t peak_bytes() const noexcept { return peak_bytes_; }

private:
    void write_vertices(int frame);
    void write_levels(int copy, double edge_pixels);
    Frame trace(int frame, const Recipe& recipe) const;

    const Crowd& crowd_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    std::vector<RTCGeometry> copies_;
    std::vector<Vec3f*> vertices_;
    std::vector<float*> levels_;
    std::vector<std::uint32_t> edges_;  ///< for each corner, the vertex after it
    std::atomic<std::size_t> bytes_ = 0, peak_bytes_ = 0;
};

}  // namespace occam::bench
