// A batch of rays sorted by direction, so that those which lie side by side may travel together.
//
// Memory   as long as the longest batch so far.
// Threads  one worker's own.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/hit.h"
#include "accel/ray_lanes.h"

namespace occam::accel {

class RayGroups {
public:
    /// By bins of direction; within a bin rays keep their order.
    void sort(std::span<const Ray> rays)
    {
        std::array<std::uint32_t, RayAxes::kBins + 1> begin{};
        unsorted_.clear();
        for (const Ray& ray : rays) {
            unsorted_.emplace_back(ray.direction);
            ++begin[unsorted_.back().bin() + 1];
        }
        for (int b = 0; b < RayAxes::kBins; ++b) begin[b + 1] += begin[b];
        // Batches come in several sizes: what has been made stays, to be written over.
        if (sorted.size() < rays.size()) {
            sorted.resize(rays.size());
            place_of.resize(rays.size());
            axes.resize(rays.size(), RayAxes(Vec3f(0, 0, 1)));
        }
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            const std::uint32_t to = begin[unsorted_[i].bin()]++;
            sorted[to] = rays[i];
            axes[to] = unsorted_[i];
            place_of[to] = i;
        }
    }

    /// Where the packet ends that begins at `first`. With one lane, rays travel alone.
    std::size_t end_of(std::size_t first, std::size_t count) const noexcept
    {
        std::size_t end = first + 1;
        while (kLanes > 1 && end < count && end < first + kPacket && axes[end].group() == axes[first].group()) ++end;
        return end;
    }

    std::vector<Ray> sorted;
    std::vector<RayAxes> axes;            ///< of these
    std::vector<std::uint32_t> place_of;  ///< in the caller's order

private:
    std::vector<RayAxes> unsorted_;
};

}  // namespace occam::accel
