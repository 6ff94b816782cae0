// Holds the rays that walk through a tree, and what both trees test them by.
//
// F is vfloat, or several of them (a packet whose rays share the signs of their directions), or float (one ray). t is in the
// tree's frame, where origins are near the scene.
#pragma once

#include <cfloat>

#include "accel/tree_leaf.h"
#include "base/simd.h"
#include "lod/ray_levels.h"

namespace occam::accel {

template <class F>
struct TreeRay {
    F origin[3], inverse[3], direction[3];
    F shift;     ///< t of the ray = shift + t here
    F off_slab;  ///< by how much the distance of its points from a plane may be off: see slab_rounding()
    bool negative[3];

    void set_off_slab() noexcept { off_slab = (abs(origin[0]) + abs(origin[1]) + abs(origin[2])) * F(slab_rounding(1)); }
};

template <class F>
using MaskOf = decltype(F() < F());

/// Clips [t_near, t_far] to a slightly widened box.
template <class F>
OCCAM_ALWAYS_INLINE void clip(const TreeRay<F>& ray, const Box3f& box, F& t_near, F& t_far) noexcept
{
    const F slack = 4 * FLT_EPSILON;
    F in = (F(ray.negative[0] ? box.hi[0] : box.lo[0]) - ray.origin[0]) * ray.inverse[0];
    F out = (F(ray.negative[0] ? box.lo[0] : box.hi[0]) - ray.origin[0]) * ray.inverse[0];
    for (int a = 1; a < 3; ++a) {
        in = max(in, (F(ray.negative[a] ? box.hi[a] : box.lo[a]) - ray.origin[a]) * ray.inverse[a]);
        out = min(out, (F(ray.negative[a] ? box.lo[a] : box.hi[a]) - ray.origin[a]) * ray.inverse[a]);
    }
    t_near = max(t_near, in - (abs(in) + abs(ray.shift)) * slack);
    t_far = min(t_far, out + (abs(out) + abs(ray.shift)) * slack);
}

/// Clips [t_near, t_far] to slightly widened boxes, one of each ray: the planes are lo.x, lo.y, lo.z, hi.x, hi.y, hi.z.
template <class F>
OCCAM_ALWAYS_INLINE void clip_to_planes(const TreeRay<F>& ray, const F (&planes)[6], F& t_near, F& t_far) noexcept
{
    const F slack = 4 * FLT_EPSILON;
    F in = F(-FLT_MAX), out = F(FLT_MAX);
    for (int a = 0; a < 3; ++a) {
        in = max(in, (planes[ray.negative[a] ? a + 3 : a] - ray.origin[a]) * ray.inverse[a]);
        out = min(out, (planes[ray.negative[a] ? a : a + 3] - ray.origin[a]) * ray.inverse[a]);
    }
    t_near = max(t_near, in - (abs(in) + abs(ray.shift)) * slack);
    t_far = min(t_far, out + (abs(out) + abs(ray.shift)) * slack);
}

/// Returns whether the ray is between the planes somewhere in [in, out].
template <class F>
OCCAM_ALWAYS_INLINE MaskOf<F> crosses(const TreeRay<F>& ray, const Slab& slab, F in, F out) noexcept
{
    if (slab.hi == FLT_MAX) return in <= out;  // all of space
    const auto dot = [&](const F(&v)[3]) {
        return fma(v[0], F(slab.normal.x), fma(v[1], F(slab.normal.y), v[2] * F(slab.normal.z)));
    };
    const F start = dot(ray.origin), speed = dot(ray.direction);
    const F a = fma(in, speed, start), b = fma(out, speed, start);
    const F low = min(a, b) - ray.off_slab, high = max(a, b) + ray.off_slab;
    return (low <= F(slab.hi)) & (high >= F(slab.lo));
}

/// Tells where rays see which pairs, as t of the tree's frame.
template <class F>
struct PairSpans {
    lod::RayLevels<F>* levels = nullptr;  ///< null if all pairs are the same to these rays
    F shift;
    int finest = 0, coarsest = 0;

    F in(int low, int high) const noexcept
    {
        levels->make();
        return widen(levels->begin(low, high), -1) - shift;
    }
    F out(int low, int high) const noexcept
    {
        levels->make();
        return widen(levels->end(low, high), 1) - shift;
    }
    /// Removes pairs that no ray sees in [near, far] from both ends of [low, high].
    void narrow(MaskOf<F> alive, F near, F far, int& low, int& high) const noexcept
    {
        levels->make();
        levels->narrow(lowest(select(alive, widen(near + shift, -1), F(FLT_MAX))),
                       highest(select(alive, widen(far + shift, 1), F(-FLT_MAX))), low, high);
    }
    bool are_all_in(PairRange range) const noexcept { return range.finest <= finest && coarsest <= range.coarsest; }

private:
    F widen(F t, float sign) const noexcept { return t + (abs(t) + abs(shift)) * F(sign * 4 * FLT_EPSILON); }
};

enum class LeafResult : unsigned char {
    Done,
    Expanded,  ///< the node has become interior for some of the pairs and must be looked at again
    Abandoned  ///< the memory budget is used up
};

}  // namespace occam::accel
