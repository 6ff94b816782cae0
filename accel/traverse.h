// Traverses the kd-tree; one traversal serves packets and single rays, nearest and any hit.
//
// One descent serves all pairs of levels of a ray: where a node is interior for fine pairs only, it is a leaf for the part
// of the ray that sees coarser pairs.
//
// Invariant: a lane is alive in a node while its t_near <= t_far there. t is in the tree's frame, where origins are
// near the scene. Intervals overlap at planes by a few ulps, since culling must never decide a hit.
#pragma once

#include "accel/kd_tree.h"
#include "accel/keyed_boxes.h"

namespace occam::accel {

/// Walks the tree front to back. limit() returns the ends of the rays' intervals as hits shorten them. leaf(node, alive,
/// t_near, t_far, finest, coarsest) intersects the rays with the igrids that a node holds for those pairs and may shorten
/// limit(). If it has a function leaf.enters(node, is_interior, t_near, t_far), that is called for each node that is
/// entered. Returns false if the walk was abandoned.
template <class F, class LimitFn, class LeafFn>
bool traverse(KdTree& tree, const RaysInTree<F, NoTimes>& rays, TraceCounters& counters, LimitFn&& limit, LeafFn&& leaf)
{
    // This is one function because a step of the walk costs less than a call.
    const TreeRay<F>& ray = rays.ray;
    const PairSpans<F>& pairs = rays.pairs;
    F t_near = rays.t_near, t_far = rays.t_far;
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
            if constexpr (requires { leaf.enters(node, true, t_near, t_far); })
                leaf.enters(node, at.is_interior() && at.level() >= pairs.finest, t_near, t_far);
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
