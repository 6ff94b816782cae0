// Says what a query keeps of the hits that it is offered while rays are traced.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cstdint>

#include "accel/grid_hit.h"
#include "accel/surface_hit.h"
#include "base/simd.h"

namespace occam::accel {

/// The t of a lane that has no ray or whose ray is finished. It is finite, so that arithmetic on it gives no NaN.
inline constexpr float kDead = -FLT_MAX;

/// The number of rays in the largest packet.
inline constexpr int kPacket = 2 * kLanes;

/// Says where surfaces have holes for the rays of a query (accel/holes.h).
struct Holes;
/// Returns whether the ray in a lane passes the igrid's surface at that point, through a hole or a hidden back.
bool passes_hole(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept;
/// Returns whether it meets a back there that the frame hides.
bool passes_back(const Holes& holes, int lane, float t, IGrid& on, std::uint32_t number) noexcept;

/// Is what all queries have: igrids that may have holes are met only if `holes` is set.
struct HoleQuery {
    const Holes* holes = nullptr;
    bool is_hole(int lane, float t, IGrid& on, std::uint32_t number) const noexcept
    {
        return on.may_have_holes && passes_hole(*holes, lane, t, on, number);
    }
};

/// Holds the nearest hits so far of up to kPacket rays.
struct Nearest : HoleQuery {
    alignas(32) float t[kPacket];  ///< t_far of the ray until a hit is found
    IGrid* grid[kPacket];
    std::uint32_t id[kPacket];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found > t[lane] || (found == t[lane] && (!grid[lane] || !comes_before(on, number, *grid[lane], id[lane]))))
            return;
        if (is_hole(lane, found, on, number)) return;
        t[lane] = found;
        grid[lane] = &on;
        id[lane] = number;
    }
};

/// Records only whether anything was hit: the t of such a ray becomes kDead.
struct AnyHit : HoleQuery {
    alignas(32) float t[kPacket];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        if (found < t[lane] && !is_hole(lane, found, on, number)) t[lane] = kDead;
    }
};

/// Holds the nearest hits so far of up to kPacket rays, several of each, in order of t.
struct NearestSome : HoleQuery {
    static constexpr int kMost = kMostNearest;
    struct Hit {
        float t;
        std::uint32_t id;
        IGrid* grid;
    };
    alignas(32) float t[kPacket];  ///< t_far of the ray until `wanted` hits are found, and then the t of the last of them
    int wanted = kMost;            ///< at most kMost
    int count[kPacket];
    Hit hits[kPacket][kMost];

    void offer(int lane, float found, IGrid& on, std::uint32_t number) noexcept
    {
        Hit* list = hits[lane];
        int& n = count[lane];
        if (!(found < t[lane] || (found == t[lane] && n == wanted))) return;
        int at = n;
        while (at > 0 && goes_before(found, on, number, list[at - 1])) --at;
        // A ray may meet an igrid twice (accel/mailboxes.h), and a triangle in several blocks (accel/spatial_split.h).
        if (at > 0 && list[at - 1].grid == &on && are_same(on, list[at - 1].id, number)) return;
        if (at == wanted || is_hole(lane, found, on, number)) return;
        n = std::min(n + 1, wanted);
        for (int i = n - 1; i > at; --i) list[i] = list[i - 1];
        list[at] = {found, number, &on};
        if (n == wanted) t[lane] = list[n - 1].t;
    }

private:
    static bool goes_before(float found, const IGrid& on, std::uint32_t number, const Hit& other) noexcept
    {
        if (found != other.t) return found < other.t;
        return comes_before(on, number, *other.grid, other.id);
    }
};

}  // namespace occam::accel
