// Vectors of three components: lanes, or floats for one ray.
#pragma once

#include "base/simd.h"

namespace occam::accel {

/// F is vfloat (points or directions in lanes, or one point as each ray of a packet sees it) or float.
template <class F>
struct VecOf {
    F x, y, z;

    friend VecOf operator+(const VecOf& a, const VecOf& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend VecOf operator-(const VecOf& a, const VecOf& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend VecOf operator-(const VecOf& a) noexcept { return {-a.x, -a.y, -a.z}; }
    friend VecOf operator*(const VecOf& a, F s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
    friend VecOf select(decltype(F() < F()) m, const VecOf& yes, const VecOf& no) noexcept
    {
        return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
    }
};
using VecLanes = VecOf<vfloat>;

OCCAM_ALWAYS_INLINE VecLanes middle(const VecLanes& a, const VecLanes& b) noexcept { return (a + b) * 0.5f; }
inline vfloat dot(const VecLanes& a, const VecLanes& b) noexcept { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
/// Returns the largest of the absolute components.
inline vfloat largest(const VecLanes& a) noexcept { return max(max(abs(a.x), abs(a.y)), abs(a.z)); }

/// Returns a * b - c * d with an error of at most 1.5 ulps (Kahan's algorithm; Jeannerod et al. 2013).
inline vfloat difference_of_products(vfloat a, vfloat b, vfloat c, vfloat d) noexcept
{
    const vfloat cd = c * d, error = fnma(c, d, cd);
    return fma(a, b, -cd) + error;
}
inline VecLanes cross(const VecLanes& a, const VecLanes& b) noexcept
{
    return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
            difference_of_products(a.x, b.y, a.y, b.x)};
}

}  // namespace occam::accel
