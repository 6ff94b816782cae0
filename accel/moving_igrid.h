// Sends rays of a packet, and single rays, through an igrid that moves.
//
// A kernel reads positions between two keys, so the rays of a packet are split by the segments of the igrid's motion in
// which their times lie: one pass for each segment, since gathering each ray's own keys costs more. Where few rays share a
// segment, each is traced alone.
#pragma once

#include <bit>

#include "accel/igrid_intersect.h"
#include "accel/leaf_boxes.h"
#include "accel/packet.h"

namespace occam::accel {

/// Refers to as many rays as there are lanes, in the frame of the igrid's cage.
struct LanesAtGrid {
    std::span<const Ray> rays;
    RaysInGrid in_grid;
};

/// Intersects the igrid with the rays whose bits are set in `which`.
template <class Found>
OCCAM_NEVER_INLINE void meet_moving(IGrid& grid, const LanesAtGrid& at, unsigned which, PartOf<Found>& query)
{
    lod::KeyTime times[kLanes];
    alignas(32) float shares[kLanes]{};
    for (unsigned left = which; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        times[lane] = lod::key_time(at.rays[lane].time, grid.segments);
        shares[lane] = times[lane].share;
    }
    const vfloat share = vfloat::load(shares);
    const RayLanes& lanes = at.in_grid.lanes;
    const RaySpan& span = at.in_grid.span;
    while (which != 0) {
        const int key = times[std::countr_zero(which)].key;
        unsigned here = 0;
        alignas(32) float is_here[kLanes]{};
        for (unsigned left = which; left != 0; left &= left - 1) {
            const int lane = std::countr_zero(left);
            if (times[lane].key != key) continue;
            here |= 1u << lane;
            is_here[lane] = 1;
        }
        which &= ~here;
        if (std::popcount(here) >= kWorthAPacket) {
            const auto as_one = [&] {
                return RaysAsOne<vfloat>(lanes.origin, lanes.inverse, at.in_grid.negative, lanes.shift, -FLT_MAX);
            };
            meet_packet(grid, at.in_grid, vfloat::load(is_here) > vfloat(0.0f), query, as_one,
                        MovingCoordinates(key, share));
            continue;
        }
        for (; here != 0; here &= here - 1) {
            const int lane = std::countr_zero(here);
            LaneOf<Found> one{query, lane};
            RayLanes ray = spread(lanes, lane);
            if (grid.blends()) ray.blend = spread(lanes.blend, lane);
            const RaySpan own{spread(span.t_near, lane), spread(span.t_end, lane)};
            meet_single(grid, {ray, at.in_grid.negative, own}, lane, one, MovingCoordinates(key, spread(share, lane)));
        }
    }
}

/// Intersects the igrid with one ray, which is in all lanes.
template <class Found>
OCCAM_NEVER_INLINE void meet_moving(IGrid& grid, const LanesAtGrid& at, SingleQuery<Found>& query)
{
    const lod::KeyTime time = lod::key_time(at.rays.front().time, grid.segments);
    meet_single(grid, at.in_grid, query.only, query, MovingCoordinates(time.key, time.share));
}

}  // namespace occam::accel
