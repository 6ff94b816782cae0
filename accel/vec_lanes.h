// Products of vectors in lanes whose rounding errors are as small as they can be, for geometry.
#pragma once

#include "base/vec_lanes.h"

namespace occam::accel {

using VecLanes = VecOf<vfloat>;
using FloatLanes = float[kLanes];
inline VecLanes load(const FloatLanes (&v)[3]) noexcept
{
    return {vfloat::load(v[0]), vfloat::load(v[1]), vfloat::load(v[2])};
}
inline void store(const VecLanes& from, FloatLanes (&to)[3]) noexcept
{
    from.x.store(to[0]);
    from.y.store(to[1]);
    from.z.store(to[2]);
}

/// Stores a vector's lanes, to be read one by one.
struct Stored {
    alignas(32) FloatLanes axis[3];
    explicit Stored(const VecLanes& v) noexcept { store(v, axis); }
    Vec3f operator[](std::size_t lane) const noexcept { return {axis[0][lane], axis[1][lane], axis[2][lane]}; }
};

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
