// Holds the hits of rays while they are traced, for packets, for parts of packets and for single rays, and gathers the
// values of rays into lanes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>

#include "accel/queries.h"
#include "accel/ray.h"
#include "base/simd_groups.h"

namespace occam::accel {

/// The number of live rays, among as many as there are lanes, below which single rays are faster (docs/performance.md).
inline constexpr int kWorthAPacket = 5;

/// Holds the hit so far of one ray, which is in the lane `only`. limit() returns its t_far in all lanes.
template <class Found>
struct SingleQuery : Found {
    int only = 0;
    vfloat limit() const noexcept { return vfloat(this->t[only]); }
    float t_of(int lane) const noexcept { return this->t[lane]; }
};

/// Holds the hits so far of a packet's rays. limit() returns the t_far of each.
template <class Found, int kParts>
struct PacketQuery : Found {
    vfloats<kParts> limit() const noexcept { return vfloats<kParts>::load(this->t); }
};

/// Refers to as many rays of a packet as there are lanes, beginning with `first`, as a query for IGridTracer.
template <class Found>
struct PartOf {
    Found& all;
    int first;
    vfloat limit() const noexcept { return vfloat::load(all.t + first); }
    float t_of(int lane) const noexcept { return all.t[first + lane]; }
    void offer(int lane, float t, IGrid& grid, std::uint32_t id) noexcept { all.offer(first + lane, t, grid, id); }
};

/// Refers to one ray of such a part, as a query for IGridTracer. limit() returns its t_far in all lanes.
template <class Found>
struct LaneOf {
    PartOf<Found> part;
    int lane;
    vfloat limit() const noexcept { return vfloat(part.all.t[part.first + lane]); }
    float t_of(int at) const noexcept { return part.t_of(at); }
    void offer(int at, float t, IGrid& grid, std::uint32_t id) noexcept { part.offer(at, t, grid, id); }
};

/// Clears the hits of one lane and sets its t to the t_far of its ray. For a ray that travels alone the other lanes may stay
/// as they are, since they are never read.
template <class Found>
void start(Found& found, int lane, float t_far)
{
    found.t[lane] = t_far;
    if constexpr (std::is_base_of_v<Nearest, Found>) found.grid[lane] = nullptr;
    if constexpr (std::is_base_of_v<NearestSome, Found>) found.count[lane] = 0;
}

/// Does so for all lanes. Those past the last ray are dead.
template <class Found>
void start(Found& found, std::span<const Ray> rays)
{
    for (int i = 0; i < kPacket; ++i) start(found, i, std::size_t(i) < rays.size() ? rays[std::size_t(i)].t_far : kDead);
}

/// Gathers four consecutive floats for each ray from `things`, `offset` bytes into each element. Lanes past the last
/// ray repeat it and are never alive.
template <class Thing>
void gather_four(const Thing* things, std::size_t count, std::size_t offset, vfloat (&to)[4]) noexcept
{
    const float* from[kLanes];
    const auto at = [&](std::size_t i) {
        return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(&things[i]) + offset);
    };
    if (count >= kLanes) {
        for (std::size_t i = 0; i < kLanes; ++i) from[i] = at(i);
    } else {
        for (std::size_t i = 0; i < kLanes; ++i) from[i] = at(std::min(i, count - 1));
    }
    load_turned(from, to);
}
template <int kParts, class Thing>
void gather_four(const Thing* things, std::size_t count, std::size_t offset, vfloats<kParts> (&to)[4]) noexcept
{
    for (int part = 0; part < kParts; ++part) {
        const std::size_t first = std::min<std::size_t>(part * kLanes, count - 1);
        vfloat turned[4];
        gather_four(things + first, count - first, offset, turned);
        for (int f = 0; f < 4; ++f) to[f].part[part] = turned[f];
    }
}

/// Returns whether a ray may see a placed cage at all, by its kind and at its time.
/// segments   of the scene's shutter
inline bool may_see(const Ray& ray, const lod::PosedCage& cage, int segments) noexcept
{
    return (ray.kinds & cage.seen_by) != 0 &&
           (cage.visible_in >> lod::key_time(ray.time, std::max(segments, 1)).key & 1) != 0;
}
template <int kParts>
vmasks<kParts> lanes_that_may_see(std::span<const Ray> rays, const lod::PosedCage& cage, int segments) noexcept
{
    float lanes[kParts * kLanes]{};
    for (std::size_t i = 0; i < rays.size(); ++i) lanes[i] = may_see(rays[i], cage, segments) ? 1.0f : 0.0f;
    return vfloats<kParts>::load(lanes) > vfloats<kParts>(0.0f);
}

}  // namespace occam::accel
