// Traverses the tree of boxes; one traversal serves packets and single rays, nearest and any hit.
//
// A packet is tested against the eight boxes of a node as one ray; the rays of a child are found when its turn comes, by the
// hits known by then. Children are visited in the order in which the first ray enters them. Levels are treated as in the
// kd-tree (accel/traverse.h).
#pragma once

#include <bit>
#include <utility>

#include "accel/bvh.h"
#include "accel/keyed_boxes.h"

namespace occam::accel {

/// Stands for boxes that move only where a packet meets some.
struct NoBox {};

/// Holds the box of a child at all times of a packet. It is not initialised: a walk has room for hundreds.
struct KeptBox {
    Vec3f lo, hi;
    bool is_loose;  ///< much larger than the box at one time
};

/// Holds the boxes of a node's children as rays see them. The rays of a packet take those that hold each box at all of their
/// times, unless these are much larger than at one time: then each takes that of its own time.
template <class F, class Times>
class ChildBoxes {
public:
    /// The type of a box that is kept until the turn of its child comes. Boxes that stand are read again.
    static constexpr bool kAreKept = Times::kMoves && !std::is_same_v<F, float>;
    using Kept = std::conditional_t<kAreKept, KeptBox, NoBox>;

    /// A node that waits for its turn.
    struct Child {
        BvhLink* node;
        const BvhNode* parent;  ///< null for nodes without a box: the root (intervals are clipped to it) and halves in time
        int child;              ///< index of the node in its parent
        float begin;            ///< where the first ray enters the box
        [[no_unique_address]] Kept kept;
    };

    OCCAM_ALWAYS_INLINE ChildBoxes(const BvhNode& node, const Times& times) noexcept : node_(node), times_(times)
    {
        if constexpr (kAreKept)
            if (node.keys.segments > 0) {
                loose_ = KeyedBoxes<F>(node.boxes(), kBoxGroupFloats, node.keys, times).sweep(swept_.floats);
            }
    }

    /// Returns the children whose boxes any of the rays may enter before `end`, and where.
    OCCAM_ALWAYS_INLINE unsigned entered(const RaysAsOne<F>& as_one, float end, float* begin) const noexcept
    {
        if constexpr (Times::kMoves && !kAreKept)
            if (node_.keys.segments > 0)
                return KeyedBoxes<F>(node_.boxes(), kBoxGroupFloats, node_.keys, times_).in_boxes(as_one, end, begin);
        return as_one.in_boxes(boxes(), end, begin);
    }
    OCCAM_ALWAYS_INLINE void keep(int child, [[maybe_unused]] Kept& to) const noexcept
    {
        if constexpr (kAreKept) {
            const Box3f box = get_box(boxes() + child, 0);
            to.lo = box.lo;
            to.hi = box.hi;
            to.is_loose = (loose_ >> child & 1) != 0;
        }
    }
    /// Clips [t_near, t_far] to the box of a child.
    OCCAM_ALWAYS_INLINE static void clip_to(const TreeRay<F>& ray, const Times& times, const Child& at, F& t_near,
                                            F& t_far) noexcept
    {
        const BvhNode& node = *at.parent;
        if constexpr (kAreKept)
            if (!at.kept.is_loose) return clip(ray, Box3f{at.kept.lo, at.kept.hi}, t_near, t_far);
        if constexpr (Times::kMoves)
            if (node.keys.segments > 0)
                return KeyedBoxes<F>(node.boxes(), kBoxGroupFloats, node.keys, times).clip_to(ray, at.child, t_near, t_far);
        clip(ray, get_box(node.boxes() + at.child, 0), t_near, t_far);
    }

private:
    struct alignas(32) Swept {
        float floats[kBoxGroupFloats];
    };
    const float* boxes() const noexcept
    {
        if constexpr (kAreKept)
            if (node_.keys.segments > 0) return swept_.floats;
        return node_.boxes();
    }

    const BvhNode& node_;
    const Times& times_;
    std::conditional_t<kAreKept, Swept, NoBox> swept_;
    unsigned loose_ = 0;  ///< the boxes that are much larger at all times than at one, as bits
};

/// Returns whether a node has a leaf that is the same for these pairs.
inline bool is_leaf_of_all(const Bvh& tree, const BvhLink* node, int finest, int coarsest) noexcept
{
    const PairRange pairs = tree.latest_leaf(node).pairs;
    return pairs.has(finest) && pairs.has(coarsest);
}

/// Returns the children whose bits are set in `entered`, a byte each: the one that is entered last is in the lowest byte.
OCCAM_NEVER_INLINE inline std::uint64_t last_entered_first(unsigned entered, const float* begin) noexcept
{
    std::uint64_t order = 0;
    for (int shift = 0; entered != 0; shift += 8) {
        int last = std::countr_zero(entered);
        for (unsigned others = entered & (entered - 1); others != 0; others &= others - 1)
            if (const int other = std::countr_zero(others); begin[other] > begin[last]) last = other;
        order |= std::uint64_t(last) << shift;
        entered &= ~(1u << last);
    }
    return order;
}

/// Does what traverse() of a KdTree does.
template <class F, class Times, class LimitFn, class LeafFn>
bool traverse(Bvh& tree, const RaysInTree<F, Times>& rays, TraceCounters& counters, LimitFn&& limit, LeafFn&& leaf)
{
    // This is one function because a step of the walk costs less than a call.
    const TreeRay<F>& ray = rays.ray;
    const PairSpans<F>& pairs = rays.pairs;
    constexpr bool kIsOne = std::is_same_v<F, float>;
    using Boxes = ChildBoxes<F, Times>;
    using Todo = typename Boxes::Child;
    Todo todo[(Bvh::kMaxDepth + 1) * BvhNode::kWidth];
    Todo* top = todo;
    Todo next{tree.root(), nullptr, 0, -FLT_MAX, {}};
    F end_now = limit();  // it changes at leaves alone
    while (true) {
        F in = rays.t_near, out = min(rays.t_far, end_now);
        // A single ray knows that it enters the box. It needs to know where only if it may see several pairs there.
        bool is_clipped = !next.parent || (kIsOne && pairs.finest == pairs.coarsest);
        const auto clip_now = [&]() __attribute__((always_inline))
        {
            if (!is_clipped) Boxes::clip_to(ray, rays.times, next, in, out);
            is_clipped = true;
        };
        if constexpr (!kIsOne) clip_now();
        MaskOf<F> alive = in <= out;
        if constexpr (Boxes::kAreKept)
            if (next.parent && next.parent->visible_in)
                alive = alive & rays.times.are_in(next.parent->visible_in[next.child]);
        bool goes_down = false;
        while (any(alive)) {
            const BvhState at = next.node->state();
            if constexpr (requires { leaf.enters(next.node, true, in, out); })
                leaf.enters(next.node, at.is_interior() && at.node().level >= pairs.finest, in, out);
            if (!at.is_interior() || at.node().level < pairs.finest) {
                if constexpr (kIsOne)
                    if (!is_clipped && !is_leaf_of_all(tree, next.node, pairs.finest, pairs.coarsest)) {
                        clip_now();
                        alive = in <= out;
                        if (none(alive)) break;
                    }
                const LeafResult result = leaf(next.node, alive, in, out, pairs.finest, pairs.coarsest);
                if (result == LeafResult::Abandoned) return false;
                end_now = limit();
                if (result == LeafResult::Expanded) continue;
                break;
            }
            BvhNode& node = at.node();
            if (node.level < pairs.coarsest) {
                if constexpr (kIsOne) clip_now();
                const F from = max(in, pairs.in(node.level + 1, pairs.coarsest)),
                        to = min(out, pairs.out(node.level + 1, pairs.coarsest));
                const MaskOf<F> coarse = alive & (from <= to);
                if (any(coarse)) {
                    if (leaf(next.node, coarse, from, to, node.level + 1, pairs.coarsest) == LeafResult::Abandoned)
                        return false;
                    end_now = limit();
                    out = min(out, end_now);
                }
                in = max(in, pairs.in(pairs.finest, node.level));
                out = min(out, pairs.out(pairs.finest, node.level));
                alive = alive & (in <= out);
                if (none(alive)) break;
            }
            ++counters.kd_visited;
            if constexpr (Times::kMoves)
                if (node.is_halved()) {
                    // Rays of either half go into its child; those that need not are not kept from it.
                    if (rays.times.last >= node.halved_at) *top++ = {&node.children[1], nullptr, 0, next.begin, {}};
                    if (rays.times.first <= node.halved_at) *top++ = {&node.children[0], nullptr, 0, next.begin, {}};
                    break;
                }
            alignas(32) float begin[BvhNode::kWidth];
            const float end = highest(select(alive, out, F(-FLT_MAX)));
            const Boxes boxes(node, rays.times);
            unsigned entered = boxes.entered(rays.as_one, end, begin);
            if constexpr (Times::kMoves)
                if (node.visible_in) entered &= node.seen_in(rays.times.segments());
            if (entered == 0) break;
            const auto set = [&](Todo & to, int child) __attribute__((always_inline))
            {
                // It is written where it stays, since reading whole what was just written in parts would wait.
                to.node = &node.children[child];
                to.parent = &node;
                to.child = child;
                to.begin = begin[child];
                boxes.keep(child, to.kept);
            };
            // The nearest child is next. The others wait, the farthest of them longest.
            int nearest = std::countr_zero(entered);
            if (const unsigned others = entered & (entered - 1); (others & (others - 1)) != 0) {
                std::uint64_t order = last_entered_first(entered, begin);
                for (int left = std::popcount(others); left > 0; --left, order >>= 8) set(*top++, int(order & 0xff));
                nearest = static_cast<int>(order);
            } else if (others != 0) {
                int farther = std::countr_zero(others);
                if (begin[farther] <= begin[nearest]) std::swap(farther, nearest);
                set(*top++, farther);
            }
            set(next, nearest);
            goes_down = true;
            break;
        }
        if (goes_down) continue;
        const float far = highest(end_now);
        do {
            if (top == todo) return true;
            next = *--top;
        } while (!(next.begin <= far));
    }
}

}  // namespace occam::accel
