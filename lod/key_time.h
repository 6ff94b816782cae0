// Moments between two keys of a motion, and what is interpolated there.
//
// A motion has 2^m segments of equal length; key k is at tau = k / 2^m of the shutter. Positions move along straight lines
// between keys. All interpolation in time is done here, by the same operations in lanes and for one float, so that a ray
// finds the same bits alone and in a packet (docs/watertightness.md, rules of motion).
#pragma once

#include <algorithm>
#include <cmath>

#include "base/simd.h"

namespace occam::lod {

/// The largest number of segments of a motion.
inline constexpr int kMostSegments = 32;

/// The moment `share` of the way from key `key` to the next one.
struct KeyTime {
    int key = 0;
    float share = 0;
};

/// Returns where tau, in [0, 1], lies among the keys of a motion with a power of two of segments. It is exact, because the
/// product only moves the binary point.
inline KeyTime key_time(float tau, int segments) noexcept
{
    const float at = (tau > 0 ? std::min(tau, 1.0f) : 0.0f) * static_cast<float>(segments);
    const int key = std::min(static_cast<int>(at), segments - 1);
    return {key, at - static_cast<float>(key)};
}

/// Returns what lies about `share` of the way from a to b, for boxes that have room for rounding: at b it is as far off as
/// anywhere between a and b.
template <class F>
OCCAM_ALWAYS_INLINE F nearly_between_keys(F share, F a, F b) noexcept
{
    return fma(share, b - a, a);
}

/// Returns what lies `share` of the way from a to b: exactly a and b at the ends, and where both are equal.
template <class F>
OCCAM_ALWAYS_INLINE F between_keys(F share, F a, F b) noexcept
{
    return select(share >= F(1.0f), b, nearly_between_keys(share, a, b));
}

}  // namespace occam::lod
