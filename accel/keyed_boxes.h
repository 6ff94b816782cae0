// Boxes that move: one at each key of an interval of the shutter, linear between keys.
//
// Packets take the boxes at all times of their rays as one; then each ray takes those at its own time.
#pragma once

#include <tuple>
#include <utility>

#include "accel/leaf_boxes.h"
#include "lod/key_time.h"

namespace occam::accel {

/// Replaces the times of rays if nothing in the frame moves.
struct NoTimes {
    static constexpr bool kMoves = false;
};

/// Returns where a time lies among the keys of an interval; a time outside of it counts as its nearer end.
inline lod::KeyTime key_time_in(const KeySpan& keys, float time) noexcept
{
    const float x = std::clamp((time - keys.begin) * keys.per_time, 0.0f, float(keys.segments));
    const int key = std::min(static_cast<int>(x), keys.segments - 1);
    return {key, x - static_cast<float>(key)};
}

/// Holds the times of rays. F is the same type as in TreeRay.
template <class F>
class RayTimes {
public:
    static constexpr bool kMoves = true;
    using Lanes = F;

    /// segments   of the scene's shutter
    RayTimes(F all, int segments) noexcept
        : time(min(max(all, F(0.0f)), F(1.0f))),
          first(lowest(time)),
          last(highest(time)),
          segments_(segments),
          per_time_(static_cast<float>(segments)),
          whole_{key_time_in({segments, 0, per_time_}, first), key_time_in({segments, 0, per_time_}, last)}
    {
    }

    /// Takes the time of one ray of a packet.
    template <class Packet>
    RayTimes(const RayTimes<Packet>& times, int lane) noexcept : RayTimes(lane_of(times.time, lane), times.segments_)
    {
    }

    F time;             ///< in [0, 1]
    float first, last;  ///< the earliest and the latest of them

    /// Returns a mask with a bit for each segment of the shutter from that of the first time to that of the last one.
    std::uint32_t segments() const noexcept { return (~0u >> (31 - whole_.second.key)) & (~0u << whole_.first.key); }
    /// Returns which rays have their time in one of these segments of the shutter.
    OCCAM_NEVER_INLINE MaskOf<F> are_in(std::uint32_t segments) const noexcept
    {
        const auto is_in = [&](float at) { return (segments >> lod::key_time(at, segments_).key & 1) != 0; };
        if constexpr (std::is_same_v<F, float>) return is_in(time);
        else {
            alignas(32) float in[sizeof(F) / sizeof(float)];
            time.store(in);
            for (float& at : in) at = is_in(at) ? 1.0f : 0.0f;
            return F::load(in) > F(0.0f);
        }
    }

    /// Returns where the first and the last time lie among the keys of an interval. Those of the whole shutter, which most
    /// nodes have, are known: no other interval has as many keys at these distances.
    OCCAM_ALWAYS_INLINE std::pair<lod::KeyTime, lod::KeyTime> ends_in(const KeySpan& keys) const noexcept
    {
        if (keys.segments == segments_ && keys.per_time == per_time_) return whole_;
        return {key_time_in(keys, first), key_time_in(keys, last)};
    }

private:
    template <class Other>
    friend class RayTimes;

    int segments_;
    float per_time_;
    std::pair<lod::KeyTime, lod::KeyTime> whole_;
};

/// Holds a group of eight boxes at each key of an interval, as rays of certain times see them. A ray whose time is outside
/// the interval sees them as they are at its nearer end.
///
/// A leaf's group may have shorter rows than eight floats. Eight are read all the same; what comes after the row's own
/// belongs to no box.
template <class F, bool kIsLeaf = false>
class KeyedBoxes {
public:
    /// stride   the number of floats from one key to the next
    OCCAM_ALWAYS_INLINE KeyedBoxes(const float* boxes, std::size_t stride, const KeySpan& keys,
                                   const RayTimes<F>& times) noexcept
        : boxes_(boxes), stride_(stride), keys_(keys), times_(times)
    {
        std::tie(from_, to_) = times.ends_in(keys);
    }

    /// Writes eight boxes that hold those of the group at the times of all rays. Returns, as bits, which of them are much
    /// larger than at the first time.
    OCCAM_ALWAYS_INLINE unsigned sweep(float* swept) const noexcept
    {
        constexpr float kMuchLarger = 1.5f;
        constexpr int kHalf = kBoxGroupFloats / 2;
        vfloat at_first[kBoxGroup / kLanes], at_all[kBoxGroup / kLanes];  // sums of extents
        for (int i = 0; i < kBoxGroup / kLanes; ++i) at_first[i] = at_all[i] = 0.0f;
        const auto note = [&](int at, vfloat first, vfloat all) {
            all.store(swept + at);
            const int i = at / kLanes % (kBoxGroup / kLanes);
            at_first[i] = at < kHalf ? at_first[i] - first : at_first[i] + first;
            at_all[i] = at < kHalf ? at_all[i] - all : at_all[i] + all;
        };
        const float* here = key(from_.key);
        if (from_.key == to_.key) {
            const vfloat first = from_.share, last = to_.share;
            for (int at = 0; at < kBoxGroupFloats; at += kLanes) {
                const vfloat a = vfloat::load(here + stored(at)), b = vfloat::load(here + stride_ + stored(at));
                const vfloat one = lod::nearly_between_keys(first, a, b), other = lod::nearly_between_keys(last, a, b);
                note(at, one, at < kHalf ? min(one, other) : max(one, other));
            }
        } else {
            for (int at = 0; at < kBoxGroupFloats; at += kLanes) {
                const vfloat first = at_moment(from_, at);
                vfloat all = first;
                const auto add = [&](vfloat x) { all = at < kHalf ? min(all, x) : max(all, x); };
                add(at_moment(to_, at));
                for (int k = from_.key + 1; k <= to_.key; ++k) add(vfloat::load(key(k) + stored(at)));
                note(at, first, all);
            }
        }
        unsigned grown = 0;
        for (int i = 0; i < kBoxGroup / kLanes; ++i)
            grown |= bits(at_all[i] > at_first[i] * vfloat(kMuchLarger)) << (i * kLanes);
        return grown;
    }
    /// Does what RaysAsOne::in_boxes does.
    OCCAM_ALWAYS_INLINE unsigned in_boxes(const RaysAsOne<F>& rays, float end, float* begin) const noexcept
    {
        const unsigned real = (1u << row()) - 1;
        if constexpr (kIsOne) return real & rays.in_boxes_by([&](int place) { return at_moment(from_, place); }, end, begin);
        else {
            alignas(32) float swept[kBoxGroupFloats];
            sweep(swept);
            return real & rays.in_boxes(swept, end, begin);
        }
    }
    /// Returns a box of the group at the time of a single ray.
    Box3f box(int place) const noexcept requires std::is_same_v<F, float>
    {
        const Box3f a = get_box(key(from_.key) + place, 0, row()), b = get_box(key(from_.key + 1) + place, 0, row());
        return {glm::mix(a.lo, b.lo, from_.share), glm::mix(a.hi, b.hi, from_.share)};
    }
    /// Clips [t_near, t_far] to a box of the group at each ray's own time.
    void clip_to(const TreeRay<F>& ray, int box, F& t_near, F& t_far) const noexcept
    {
        const F at = min(max((times_.time - F(keys_.begin)) * F(keys_.per_time), F(0.0f)), F(float(keys_.segments)));
        F planes[6];
        interpolate(from_.key, box, at, planes);
        // Rays that see other segments take the box of theirs.
        for (int k = from_.key + 1; k <= to_.key; ++k) {
            const MaskOf<F> is_later = at >= F(float(k));
            F later[6];
            interpolate(k, box, at, later);
            for (int p = 0; p < 6; ++p) planes[p] = select(is_later, later[p], planes[p]);
        }
        clip_to_planes(ray, planes, t_near, t_far);
    }

private:
    static constexpr bool kIsOne = std::is_same_v<F, float>;

    /// Returns a box between two keys, where each ray is `at` keys from the first one.
    OCCAM_ALWAYS_INLINE void interpolate(int k, int box, F at, F (&planes)[6]) const noexcept
    {
        const float *here = key(k) + box, *next = here + stride_;
        const F share = at - F(float(k));
        for (int p = 0; p < 6; ++p) planes[p] = lod::nearly_between_keys(share, F(here[p * row()]), F(next[p * row()]));
    }
    const float* key(int k) const noexcept { return boxes_ + static_cast<std::size_t>(k) * stride_; }
    /// Returns the number of floats in a row.
    int row() const noexcept { return kIsLeaf ? keys_.row : kBoxGroup; }
    /// Returns where a place in a group of eight boxes is stored.
    int stored(int place) const noexcept { return kIsLeaf ? place / kBoxGroup * keys_.row + place % kBoxGroup : place; }
    OCCAM_ALWAYS_INLINE vfloat at_moment(const lod::KeyTime& moment, int place) const noexcept
    {
        const float* here = key(moment.key) + stored(place);
        return lod::nearly_between_keys(vfloat(moment.share), vfloat::load(here), vfloat::load(here + stride_));
    }

    const float* boxes_;
    std::size_t stride_;
    const KeySpan& keys_;
    lod::KeyTime from_, to_;
    const RayTimes<F>& times_;
};

/// Holds all that a walk through a tree reads of its rays.
template <class F, class RayTimesOrNone>
struct RaysInTree {
    const TreeRay<F>& ray;
    const RaysAsOne<F>& as_one;   ///< all of them as one
    const RayTimesOrNone& times;  ///< NoTimes if nothing moves, else RayTimes<F>
    F t_near, t_far;              ///< each ray's interval, clipped to the tree
    const PairSpans<F>& pairs;
};

}  // namespace occam::accel
