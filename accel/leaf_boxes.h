// Tests the boxes of a leaf's entries, eight at a time, against a ray, or against all rays of a packet as one.
//
// A packet's origins and inverse directions are taken as intervals (Reshetov et al. 2005, sec. 2). A box that they miss
// is missed by all of the packet's rays; the remaining boxes are tested ray by ray. So a leaf costs a packet a few
// tests instead of one per entry. The blocks of an igrid are tested in the same way.
//
// Boxes    TreeLeaf::boxes and BoxTree share one layout. Spare slots hold empty boxes.
#pragma once

#include <cmath>

#include "accel/tree_ray.h"
#include "base/simd_groups.h"

namespace occam::accel {

/// F is the same type as in TreeRay: vfloat for a packet, float for one ray.
template <class F>
class RaysAsOne {
public:
    RaysAsOne() = default;
    /// begin   is where the first of the rays starts.
    RaysAsOne(const TreeRay<F>& rays, float begin) noexcept
        : RaysAsOne(rays.origin, rays.inverse, rays.negative, rays.shift, begin)
    {
    }
    /// Takes one ray of a packet.
    template <class Packet>
    RaysAsOne(const TreeRay<Packet>& rays, int lane, const Packet& begin) noexcept
        : begin_(lane_of(begin, lane)), shift_(std::abs(lane_of(rays.shift, lane)))
    {
        for (int a = 0; a < 3; ++a) {
            from_in_[a] = from_out_[a] = vfloat(lane_of(rays.origin[a], lane));
            least_[a] = most_[a] = vfloat(lane_of(rays.inverse[a], lane));
            near_[a] = (rays.negative[a] ? a + 3 : a) * kBoxGroup;
            far_[a] = (rays.negative[a] ? a : a + 3) * kBoxGroup;
        }
    }
    RaysAsOne(const F (&origin)[3], const F (&inverse)[3], const bool (&negative)[3], F shift, float begin) noexcept
        : begin_(begin), shift_(highest(abs(shift)))
    {
        for (int a = 0; a < 3; ++a) {
            const float low = lowest(origin[a]), high = highest(origin[a]);
            from_in_[a] = negative[a] ? low : high;
            from_out_[a] = negative[a] ? high : low;
            least_[a] = lowest(inverse[a]);
            most_[a] = highest(inverse[a]);
            near_[a] = (negative[a] ? a + 3 : a) * kBoxGroup;
            far_[a] = (negative[a] ? a : a + 3) * kBoxGroup;
        }
    }

    /// Returns a mask in which bit i is set if some ray may be in box i of the group before `end`. If `begin` is given, it
    /// receives where each box may be entered.
    unsigned in_boxes(const float* group, float end, float* begin = nullptr) const noexcept
    {
        return in_boxes_by([group](int place) { return vfloat::load(group + place); }, end, begin);
    }
    /// Does the same for boxes whose coordinates are load(place), as many as there are lanes.
    template <class Load>
    OCCAM_ALWAYS_INLINE unsigned in_boxes_by(Load&& load, float end, float* begin) const noexcept
    {
        unsigned all = 0;
        for (int first = 0; first < kBoxGroup; first += kLanes) {
            vfloat in = -FLT_MAX, out = FLT_MAX;
            for (int a = 0; a < 3; ++a) {
                in = max(in, times(load(near_[a] + first) - from_in_[a], least_[a], most_[a]));
                out = min(out, times(load(far_[a] + first) - from_out_[a], most_[a], least_[a]));
            }
            const vfloat slack = 4 * FLT_EPSILON;
            in = in - (abs(in) + shift_) * slack;
            out = out + (abs(out) + shift_) * slack;
            if (begin) in.store(begin + first);
            all |= bits((in <= out) & (in <= vfloat(end)) & (out >= begin_)) << first;
        }
        return all;
    }

private:
    static constexpr bool kIsOne = std::is_same_v<F, float>;

    static vfloat times(vfloat x, vfloat if_positive, vfloat if_negative) noexcept
    {
        if constexpr (kIsOne) return x * if_positive;
        else return x * select(x >= vfloat(0.0f), if_positive, if_negative);
    }

    vfloat begin_, shift_;
    vfloat from_in_[3], from_out_[3];  ///< the origins that give the earliest entry and the latest exit
    vfloat least_[3], most_[3];        ///< bounds of the inverse directions, all of one sign
    int near_[3], far_[3];             ///< rows of the planes that rays cross first, and last
};

}  // namespace occam::accel
