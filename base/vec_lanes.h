// Vectors of three components: lanes, or floats for one ray. How products are rounded is for each room to say.
#pragma once

#include "base/simd.h"

namespace occam {

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

}  // namespace occam
