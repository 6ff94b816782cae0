// Numbers, vectors and colours in lanes, with products that have the bits of GLM's, and their storage lane by lane.
#pragma once

#include <cstring>
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

/// Holds as many values as there are lanes, one by one.
struct LaneFloats {
    alignas(32) float of[kLanes];

    vfloat lanes() const noexcept { return vfloat::load(of); }
    void operator=(vfloat x) noexcept { x.store(of); }
};

/// Holds as many vectors as there are lanes, one by one.
struct LaneVectors {
    LaneFloats x, y, z;

    void set(int lane, Vec3f v) noexcept { x.of[lane] = v.x, y.of[lane] = v.y, z.of[lane] = v.z; }
    Vec3f at(int lane) const noexcept { return {x.of[lane], y.of[lane], z.of[lane]}; }
    VecLanes lanes() const noexcept { return {x.lanes(), y.lanes(), z.lanes()}; }
    void operator=(const VecLanes& v) noexcept { x = v.x, y = v.y, z = v.z; }
};

/// Holds a vector and a number for each lane, to be read one lane after the other.
class LaneRows {
public:
    void set(const VecLanes& v, vfloat number) noexcept
    {
        float* to[kLanes];
        for (int i = 0; i < kLanes; ++i) to[i] = rows_[i];
        store_turned({v.x, v.y, v.z, number}, to, 0);
    }
    Vec3f vector(int lane) const noexcept
    {
        Vec3f v;
        std::memcpy(&v, rows_[lane], sizeof v);
        return v;
    }
    float number(int lane) const noexcept { return rows_[lane][3]; }

private:
    alignas(16) float rows_[kLanes][4];
};

}  // namespace occam::shade
