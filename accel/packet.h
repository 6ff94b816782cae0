// Rays of a group in lanes: what they ask, and how their numbers get there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>

#include "accel/hit.h"
#include "base/simd_groups.h"

namespace occam::accel {

/// Live rays, of as many as there are lanes, below which single rays are faster (docs/performance.md).
inline constexpr int kWorthAPacket = 5;

/// One ray and what it has met so far. limit(): in all lanes.
template <class Found>
struct SingleQuery : Found {
    int only = 0;
    vfloat limit() const noexcept { return vfloat(this->t[only]); }
};

/// A packet's rays.
template <class Found, int kParts>
struct PacketQuery : Found {
    vfloats<kParts> limit() const noexcept { return vfloats<kParts>::load(this->t); }
};

/// As many of them as there are lanes, as a query of their own: what meets an igrid.
template <class Found>
struct PartOf {
    Found& all;
    int first;
    vfloat limit() const noexcept { return vfloat::load(all.t + first); }
    void offer(int lane, float t, IGrid& grid, std::uint32_t id) noexcept { all.offer(first + lane, t, grid, id); }
};

/// One of these.
template <class Found>
struct LaneOf {
    PartOf<Found> part;
    int lane;
    vfloat limit() const noexcept { return vfloat(part.all.t[part.first + lane]); }
    void offer(int at, float t, IGrid& grid, std::uint32_t id) noexcept { part.offer(at, t, grid, id); }
};

/// Nothing met yet; lanes past the last ray are dead.
template <class Found>
void start(Found& found, std::span<const Ray> rays)
{
    for (int i = 0; i < kPacket; ++i) {
        found.t[i] = std::size_t(i) < rays.size() ? rays[i].t_far : kDead;
        if constexpr (std::is_base_of_v<Nearest, Found>) found.grid[i] = nullptr;
    }
}

/// Four floats of each ray that lie one behind the other in `things`, `offset` bytes into each. Lanes past the last ray
/// repeat it, and are never alive.
template <class Thing>
void gather_four(const Thing* things, std::size_t count, std::size_t offset, vfloat (&to)[4]) noexcept
{
    const float* from[kLanes];
    for (int i = 0; i < kLanes; ++i)
        from[i] = reinterpret_cast<const float*>(
            reinterpret_cast<const std::byte*>(&things[std::min<std::size_t>(i, count - 1)]) + offset);
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

template <int kParts>
vmasks<kParts> lanes_of_kinds(std::span<const Ray> rays, std::uint8_t kinds) noexcept
{
    float lanes[kParts * kLanes]{};
    for (std::size_t i = 0; i < rays.size(); ++i) lanes[i] = (rays[i].kinds & kinds) != 0 ? 1.0f : 0.0f;
    return vfloats<kParts>::load(lanes) > vfloats<kParts>(0.0f);
}

}  // namespace occam::accel
