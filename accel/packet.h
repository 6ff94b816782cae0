// Rays of a group in lanes: what they ask, and how their numbers get there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>

#include "accel/hit.h"

namespace occam::accel {

/// Rays and what they have met so far. limit() of a single ray is the same in all lanes.
template <class Found, bool kSingle>
struct Query : Found {
    int only = 0;
    vfloat limit() const noexcept
    {
        if constexpr (kSingle) return vfloat(this->t[only]);
        else return vfloat::load(this->t);
    }
};

/// One ray of a packet, as a query of its own.
template <class Found>
struct LaneOf {
    Found& all;
    int lane;
    vfloat limit() const noexcept { return vfloat(all.t[lane]); }
    void offer(int at, float t, IGrid& grid, std::uint32_t id) noexcept { all.offer(at, t, grid, id); }
};

/// Nothing met yet; lanes past the last ray are dead.
template <class Found>
void start(Found& found, std::span<const Ray> rays)
{
    for (int i = 0; i < kLanes; ++i) {
        found.t[i] = std::size_t(i) < rays.size() ? rays[i].t_far : kDead;
        if constexpr (std::is_base_of_v<Nearest, Found>) found.grid[i] = nullptr;
    }
}

/// Lanes of a group: rays past its end repeat the last one and are never alive.
template <class Get>
vfloat gather(std::size_t count, Get&& get) noexcept
{
    alignas(32) float lanes[kLanes];
    for (int i = 0; i < kLanes; ++i) lanes[i] = get(std::min<std::size_t>(i, count - 1));
    return vfloat::load(lanes);
}

/// The same of four floats of each ray that lie one behind the other in `things`, `offset` bytes into each.
template <class Thing>
void gather_four(const Thing* things, std::size_t count, std::size_t offset, vfloat (&to)[4]) noexcept
{
    const float* from[kLanes];
    for (int i = 0; i < kLanes; ++i) from[i] = reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(&things[std::min<std::size_t>(i, count - 1)]) + offset);
    load_turned(from, to);
}

inline vmask lanes_of_kinds(std::span<const Ray> rays, std::uint8_t kinds) noexcept
{
    return gather(rays.size(), [&](std::size_t i) { return (rays[i].kinds & kinds) != 0 ? 1.0f : 0.0f; }) > vfloat(0.0f);
}

}  // namespace occam::accel
