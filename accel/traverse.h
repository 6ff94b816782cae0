// Traverses the kd-tree; one traversal serves packets and single rays, nearest and any hit.
//
// F is vfloat (a packet whose rays share the signs of their directions) or float (one ray). One descent serves all
// pairs of levels of a ray: where a node is interior for fine pairs only, it is a leaf for the part of the ray that sees
// coarser pairs.
//
// Invariant: a lane is alive in a node while its t_near <= t_far there. t is in the tree's frame, where origins are
// near the scene. Intervals overlap at planes by a few ulps, since culling must never decide a hit.
#pragma once

#include <cfloat>

#include "accel/kd_tree.h"
#include "base/simd.h"
#include "lod/ray_levels.h"

namespace occam::accel {

template <class F>
struct KdRay {
    F origin[3], inverse[3], direction[3];
    F shift;  ///< t of the ray = shift + t here
    bool negative[3];
};

template <class F>
using MaskOf = decltype(F() < F());

/// Clips [t_near, t_far] to a slightly widened box.
template <class F>
OCCAM_ALWAYS_INLINE void clip(const KdRay<F>& ray, const Box3f& box, F& t_near, F& t_far) noexcept
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

/// Returns whether the ray is between the planes somewhere in [in, out].
template <class F>
OCCAM_ALWAYS_INLINE MaskOf<F> crosses(const KdRay<F>& ray, const Slab& slab, F in, F out) noexcept
{
    const auto dot = [&](const F(&v)[3]) {
        return fma(v[0], F(slab.normal.x), fma(v[1], F(slab.normal.y), v[2] * F(slab.normal.z)));
    };
    const F start = dot(ray.origin), speed = dot(ray.direction);
    const F a = fma(in, speed, start), b = fma(out, speed, start);
    const F low = min(a, b), high = max(a, b);
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

/// Walks the tree front to back. t_near and t_far hold each ray's interval, clipped to the tree; limit() returns its
/// end as hits shorten it. leaf(node, alive, t_near, t_far, finest, coarsest) intersects the rays with the igrids that a
/// node holds for those pairs and may shorten limit(). Returns false if the walk was abandoned.
template <class F, class LimitFn, class LeafFn>
bool traverse(KdTree& tree, const KdRay<F>& ray, F t_near, F t_far, const PairSpans<F>& pairs, TraceCounters& counters,
              LimitFn&& limit, LeafFn&& leaf)
{
    struct Span {
        std::uint32_t node;
        F t_near, t_far;
    };
    Span todo[KdTree::kMaxDepth + 4];
    int size = 0;
    std::uint32_t node = 0;
    while (true) {
        t_far = min(t_far, limit());
        MaskOf<F> alive = t_near <= t_far;
        while (any(alive)) {
            const KdNode& there = tree.node(node);
            const KdLink at = there.link();
            if (!at.is_interior() || at.level() < pairs.finest) {
                const LeafResult result = leaf(node, alive, t_near, t_far, pairs.finest, pairs.coarsest);
                if (result == LeafResult::Abandoned) return false;
                if (result == LeafResult::Expanded) continue;
                break;
            }
            if (at.level() < pairs.coarsest) {
                const F from = max(t_near, pairs.in(at.level() + 1, pairs.coarsest)),
                        to = min(t_far, pairs.out(at.level() + 1, pairs.coarsest));
                const MaskOf<F> coarse = alive & (from <= to);
                if (any(coarse)) {
                    if (leaf(node, coarse, from, to, at.level() + 1, pairs.coarsest) == LeafResult::Abandoned) return false;
                    t_far = min(t_far, limit());
                }
                t_near = max(t_near, pairs.in(pairs.finest, at.level()));
                t_far = min(t_far, pairs.out(pairs.finest, at.level()));
                alive = alive & (t_near <= t_far);
                if (none(alive)) break;
            }
            ++counters.kd_visited;
            const int axis = at.axis();
            const bool flip = ray.negative[axis];
            const std::uint32_t front = at.first_child() + (flip ? 1u : 0u), back = at.first_child() + (flip ? 0u : 1u);
            const F t_split = (F(there.split) - ray.origin[axis]) * ray.inverse[axis];
            const F slack = (abs(t_split) + abs(ray.shift)) * F(4 * FLT_EPSILON);
            const F front_end = t_split + slack, back_begin = t_split - slack;
            const MaskOf<F> into_front = alive & (t_near <= front_end), into_back = alive & (back_begin <= t_far);
            if (!any(into_back)) {
                node = front;
                t_far = min(front_end, t_far);
                alive = into_front;
                continue;
            }
            if (!any(into_front)) {
                node = back;
                t_near = max(back_begin, t_near);
                alive = into_back;
                continue;
            }
            // A lane that does not go on has an empty interval.
            todo[size++] = {back, select(into_back, max(back_begin, t_near), F(FLT_MAX)), t_far};
            node = front;
            t_near = select(into_front, t_near, F(FLT_MAX));
            t_far = min(front_end, t_far);
            alive = into_front;
        }
        if (size == 0) return true;
        const Span& next = todo[--size];
        node = next.node;
        t_near = next.t_near;
        t_far = next.t_far;
    }
}

}  // namespace occam::accel
