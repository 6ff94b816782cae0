// Traverses the tree of boxes; one traversal serves packets and single rays, nearest and any hit.
//
// A packet is tested against the eight boxes of a node as one ray; the rays of a child are found when its turn comes, by the
// hits known by then. Children are visited in the order in which the first ray enters them. Levels are treated as in the
// kd-tree (accel/traverse.h).
#pragma once

#include <utility>

#include "accel/bvh.h"
#include "accel/leaf_boxes.h"

namespace occam::accel {

/// Does what traverse() of a KdTree does. as_one   holds all the rays as one.
template <class F, class LimitFn, class LeafFn>
bool traverse(Bvh& tree, const TreeRay<F>& ray, const RaysAsOne<F>& as_one, F t_near, F t_far, const PairSpans<F>& pairs,
              TraceCounters& counters, LimitFn&& limit, LeafFn&& leaf)
{
    constexpr bool kIsOne = std::is_same_v<F, float>;
    struct Todo {
        BvhLink* node;
        const float* box;  ///< null for the root: the intervals are clipped to it
        float begin;       ///< where the first ray enters the box
    };
    Todo todo[Bvh::kMaxDepth * (BvhNode::kWidth - 1) + BvhNode::kWidth];
    int size = 0;
    Todo next{tree.root(), nullptr, -FLT_MAX};
    while (true) {
        F in = t_near, out = min(t_far, limit());
        // A single ray knows that it enters the box; the levels alone need to know where.
        if (next.box && (!kIsOne || pairs.levels)) clip(ray, get_box(next.box, 0), in, out);
        MaskOf<F> alive = in <= out;
        while (any(alive)) {
            const BvhState at = next.node->state();
            if (!at.is_interior() || at.node().level < pairs.finest) {
                const LeafResult result = leaf(next.node, alive, in, out, pairs.finest, pairs.coarsest);
                if (result == LeafResult::Abandoned) return false;
                if (result == LeafResult::Expanded) continue;
                break;
            }
            const BvhNode& node = at.node();
            if (node.level < pairs.coarsest) {
                const F from = max(in, pairs.in(node.level + 1, pairs.coarsest)),
                        to = min(out, pairs.out(node.level + 1, pairs.coarsest));
                const MaskOf<F> coarse = alive & (from <= to);
                if (any(coarse)) {
                    if (leaf(next.node, coarse, from, to, node.level + 1, pairs.coarsest) == LeafResult::Abandoned)
                        return false;
                    out = min(out, limit());
                }
                in = max(in, pairs.in(pairs.finest, node.level));
                out = min(out, pairs.out(pairs.finest, node.level));
                alive = alive & (in <= out);
                if (none(alive)) break;
            }
            ++counters.kd_visited;
            alignas(32) float begin[BvhNode::kWidth];
            const int base = size;
            for (unsigned entered = as_one.in_boxes(node.boxes(), highest(select(alive, out, F(-FLT_MAX))), begin);
                 entered != 0; entered &= entered - 1) {
                const int child = std::countr_zero(entered);
                todo[size++] = {const_cast<BvhLink*>(&node.children[child]), node.boxes() + child, begin[child]};
                // The nearest one comes last and is taken first.
                for (int k = size - 1; k > base && todo[k].begin > todo[k - 1].begin; --k) std::swap(todo[k], todo[k - 1]);
            }
            break;
        }
        const float far = highest(limit());
        do {
            if (size == 0) return true;
            next = todo[--size];
        } while (!(next.begin <= far));
    }
}

}  // namespace occam::accel
