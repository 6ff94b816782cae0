// Sorts a batch of rays by direction, so that rays which lie side by side may travel together. Where things move far, rays
// are sorted by time first (Hou et al. 2010): rays of about one time see what moves in about one place (accel/time_order.h).
//
// Memory   As long as the longest batch so far.
// Threads  Each worker has its own.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/packet.h"
#include "accel/ray_lanes.h"
#include "accel/time_order.h"
#include "base/kept_blocks.h"

namespace occam::accel {

class RayGroups {
public:
    /// Sorts rays by bins of direction; within a bin, rays keep their order.
    /// most_times   the largest number of bins of time, which come first; 1: rays are not sorted by time
    void sort(std::span<const Ray> rays, std::size_t most_times)
    {
        // Batches come in several sizes: existing entries are kept and overwritten.
        if (sorted.size() < rays.size()) {
            sorted.resize(rays.size());
            place_of.resize(rays.size());
            bins_.resize(rays.size());
        }
        std::array<std::uint32_t, kBins + 1> of_bin{};
        for (std::size_t first = 0; first < rays.size(); first += kLanes) {
            const std::size_t count = std::min<std::size_t>(kLanes, rays.size() - first);
            float bins[kLanes];
            bins_of(&rays[first], count).store(bins);
            for (std::size_t i = 0; i < count; ++i) {
                bins_[first + i] = static_cast<std::uint16_t>(bins[i]);
                ++of_bin[bins_[first + i] + 1u];
            }
        }
        groups_ = RayAxes::kGroups;
        const std::size_t times = std::min(most_times, times_for(rays.size(), of_bin));
        if (times <= 1) return put_in_order(rays, of_bin);
        std::array<std::uint32_t, kMostTimes * kBins + 1> of_time{};
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto time = static_cast<std::size_t>(lod::key_time(rays[i].time, static_cast<int>(times)).key);
            bins_[i] = static_cast<std::uint16_t>(bins_[i] + time * kBins);
            ++of_time[bins_[i] + 1u];
        }
        groups_ *= times;
        put_in_order(rays, of_time);
    }

    /// Calls travel(axes, first, count) for the rays sorted[first, first + count) that share their axes. With one lane,
    /// rays travel alone.
    template <class Travel>
    void for_each_packet(Travel&& travel) const
    {
        constexpr std::size_t kMost = kLanes > 1 ? kPacket : 1;
        std::size_t first = 0;
        for (std::size_t g = 0; g < groups_; ++g) {
            const RayAxes axes(static_cast<int>(g % RayAxes::kGroups));
            for (std::size_t count = 0; first < ends_[g]; first += count) {
                count = std::min(kMost, ends_[g] - first);
                travel(axes, first, count);
            }
        }
    }

    KeptVector<Ray> sorted;
    KeptVector<std::uint32_t> place_of;  ///< index of each sorted ray in the caller's batch

private:
    static constexpr std::size_t kBinsOfAGroup = 4, kBins = RayAxes::kGroups * kBinsOfAGroup,
                                 kMostTimes = TimeOrder::kMostBins;

    /// Returns the number of bins of time: so few that there are rays for a packet in each of them and each group of axes.
    static std::size_t times_for(std::size_t rays, const std::array<std::uint32_t, kBins + 1>& of_bin) noexcept
    {
        std::size_t groups = 0;
        for (std::size_t g = 0; g < RayAxes::kGroups; ++g) {
            const std::uint32_t* first = &of_bin[g * kBinsOfAGroup + 1];
            groups += std::any_of(first, first + kBinsOfAGroup, [](std::uint32_t count) { return count > 0; });
        }
        return std::bit_floor(std::clamp(rays / std::max<std::size_t>(1, groups * kPacket), std::size_t(1), kMostTimes));
    }
    /// Copies rays in the order of their bins. next[b + 1] is the number of rays in bin b.
    template <std::size_t kCount>
    void put_in_order(std::span<const Ray> rays, std::array<std::uint32_t, kCount>& next)
    {
        const std::size_t bins = groups_ * kBinsOfAGroup;
        for (std::size_t b = 0; b < bins; ++b) next[b + 1] += next[b];
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            const std::uint32_t to = next[bins_[i]]++;
            sorted[to] = rays[i];
            place_of[to] = i;
        }
        for (std::size_t g = 0; g < groups_; ++g) ends_[g] = next[g * kBinsOfAGroup + kBinsOfAGroup - 1];
    }

    /// Returns, in lanes, the group of a ray and whether it goes more than half as far along its lesser axes.
    static vfloat bins_of(const Ray* rays, std::size_t count) noexcept
    {
        vfloat d[4];
        gather_four(rays, count, offsetof(Ray, direction), d);
        const vfloat x = abs(d[0]), y = abs(d[1]), z = abs(d[2]), zero = 0.0f;
        const vmask more_x = x > y, is_x = more_x & (x > z), is_y = andnot(y > z, more_x);
        const vfloat half = vfloat(0.5f) * select(is_x, x, select(is_y, y, z));
        const auto if_so = [&](vmask m, float value) { return select(m, value, zero); };
        const vfloat group = select(is_x, zero, select(is_y, 8.0f, 16.0f)) +
                             (if_so(d[0] < zero, 1) + if_so(d[1] < zero, 2)) + if_so(d[2] < zero, 4);
        return group * float(kBinsOfAGroup) + if_so(select(is_x, y, select(is_y, z, x)) > half, 2) +
               if_so(select(is_x, z, select(is_y, x, y)) > half, 1);
    }

    KeptVector<std::uint16_t> bins_;                     ///< in the caller's order
    std::size_t groups_ = 0;                             ///< groups of axes, times bins of time
    std::size_t ends_[kMostTimes * RayAxes::kGroups]{};  ///< end of each group in `sorted`
};

}  // namespace occam::accel
