// Vectors and colours in lanes, with products that have the bits of GLM's.
#pragma once

#include <type_traits>

#include "base/vec.h"
#include "base/vec_lanes.h"

namespace occam::shade {

using VecLanes = VecOf<vfloat>;

/// Holds three channels or components: Vec3f for one surface, VecLanes for several.
template <class F>
using Triple = std::conditional_t<std::is_same_v<F, float>, Vec3f, VecLanes>;

inline Vec3f all_channels(float x) noexcept { return Vec3f(x); }
inline VecLanes all_channels(vfloat x) noexcept { return {x, x, x}; }

inline vfloat dot(const VecLanes& a, const VecLanes& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline VecLanes cross(const VecLanes& a, const VecLanes& b) noexcept
{
    return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}
inline vfloat length(const VecLanes& a) noexcept { return sqrt(dot(a, a)); }
inline VecLanes normalized(const VecLanes& a) noexcept { return a * (vfloat(1.0f) / sqrt(dot(a, a))); }
inline VecLanes divided(const VecLanes& a, vfloat by) noexcept { return {a.x / by, a.y / by, a.z / by}; }
/// Multiplies channel by channel.
inline VecLanes times(const VecLanes& a, const VecLanes& b) noexcept { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline vmask is_black(const VecLanes& a) noexcept
{
    const vfloat zero = 0.0f;
    return (a.x == zero) & (a.y == zero) & (a.z == zero);
}

}  // namespace occam::shade
