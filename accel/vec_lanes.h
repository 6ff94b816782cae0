// Vectors of three in lanes.
#pragma once

#include "scenegraph/base/simd.h"

namespace occam::accel {

struct VecLanes {
    vfloat x, y, z;

    VecLanes() = default;
    VecLanes(vfloat all) noexcept : x(all), y(all), z(all) {}
    VecLanes(vfloat x_, vfloat y_, vfloat z_) noexcept : x(x_), y(y_), z(z_) {}

    friend VecLanes operator+(const VecLanes& a, const VecLanes& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend VecLanes operator-(const VecLanes& a, const VecLanes& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend VecLanes operator-(const VecLanes& a) noexcept { return {-a.x, -a.y, -a.z}; }
    friend VecLanes operator*(const VecLanes& a, vfloat s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
};

inline VecLanes select(vmask m, const VecLanes& yes, const VecLanes& no) noexcept
{
    return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}
inline vfloat dot(const VecLanes& a, const VecLanes& b) noexcept { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
/// Of the absolute components.
inline vfloat largest(const VecLanes& a) noexcept { return max(max(abs(a.x), abs(a.y)), abs(a.z)); }

/// a * b - c * d, to 1.5 ulps (Kahan's).
inline vfloat difference_of_products(vfloat a, vfloat b, vfloat c, vfloat d) noexcept
{
    const vfloat cd = c * d, error = fnma(c, d, cd);
    return fma(a, b, -cd) + error;
}
inline VecLanes cross(const VecLanes& a, const VecLanes& b) noexcept
{
    return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z), difference_of_products(a.x, b.y, a.y, b.x)};
}

}  // namespace occam::accel
