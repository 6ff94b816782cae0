// Sends rays through a tree: all that a packet and a ray alone have in common.
//
// Way names the tree (accel/tracer_state.h), and Party holds the rays: PacketRays or LoneRay. The party says where the rays
// are, which of them meet an igrid, and intersects them with it; everything else is here.
#pragma once

#include <algorithm>
#include <bit>
#include <cfloat>

#include "accel/leaf_group.h"
#include "accel/narration.h"
#include "accel/tracer_state.h"
#include "base/cancellation.h"

namespace occam::accel {

template <class Way, class Party>
class Tracer::State::Walk {
    using F = typename Party::Lanes;
    using Mask = MaskOf<F>;
    using Tree = typename Way::Tree;
    using Times = typename Way::template Times<F>;
    static constexpr bool kIsOne = std::is_same_v<F, float>;
    static constexpr bool kIsObservedRay = kIsObserved<typename Party::Found>;

public:
    /// memory_bytes   what the tree may take; if it takes more, the walk is abandoned
    Walk(State& state, Party& party, std::size_t memory_bytes)
        : state_(state), party_(party), ray_(party.in_tree), memory_bytes_(memory_bytes), tree_(state.lazy.tree<Tree>())
    {
    }

    PacketResult run()
    {
        const F t_near = party_.t_near();
        begin_ = t_near - ray_.shift;
        F end = party_.t_far() - ray_.shift;
        begin_ = begin_ - (abs(t_near) + abs(ray_.shift)) * F(4 * FLT_EPSILON);
        clip(ray_, state_.frame.bounds, begin_, end);
        const Mask enters = begin_ <= end;
        if constexpr (kIsObservedRay) narrate_start(enters);
        if (none(enters)) return PacketResult::Done;
        pairs_ = {nullptr, ray_.shift, 0, 0};
        if (state_.frame.has_levels) {
            lod::RayLevels<F>* const levels = find_levels(enters, end);
            if (!levels) return PacketResult::TooWide;
            pairs_ = {levels, ray_.shift, levels->finest, levels->coarsest};
        }
        if constexpr (kIsObservedRay) narrate_levels();
        ++state_.visit;
        if constexpr (!kIsOne) ++state_.counters.packets;
        // Where a ray that misses the scene would begin may be no number, and says nothing about the others.
        as_one_ = RaysAsOne<F>(ray_, lowest(select(enters, begin_, F(FLT_MAX))));
        const Times times = times_of<Times>(party_.rays(), state_.frame.segments);
        const auto limit = [&] { return this->limit(); };
        const auto leaf = [&](auto node, const Mask& alive, const F& near, const F& far, int finest, int coarsest) {
            return meet_leaf(node, alive, near, far, {finest, coarsest}, times);
        };
        unsigned inside = 1;
        if constexpr (Times::kMoves && !kIsOne) inside = bits(enters);
        const auto walk = [&](const auto& at_leaf) {
            const std::uint64_t before = state_.counters.kd_visited;
            const bool is_done = traverse(tree_, RaysInTree<F, Times>{ray_, as_one_, times, begin_, end, pairs_},
                                          state_.counters, limit, at_leaf);
            if constexpr (Times::kMoves) {
                const std::uint64_t nodes = state_.counters.kd_visited - before;
                (kIsOne ? state_.visits.nodes_of_lone_rays : state_.visits.nodes) += nodes;
                if constexpr (kIsOne) ++state_.visits.lone_rays;
                state_.visits.rays_inside += static_cast<std::uint64_t>(std::popcount(inside));
            }
            return is_done ? PacketResult::Done : PacketResult::Abandoned;
        };
        if constexpr (kIsObservedRay)
            if (Narration* const to = party_.query.narration)
                return walk(NarratedWalk{*to, tree_, ray_, times, pairs_, begin_, limit, leaf});
        return walk(leaf);
    }

private:
    /// Makes the table of levels of the rays `enters`. A ray that misses what is diced may have any table. The table of a
    /// ray that goes on behind a surface is that with which it came there, so it does not depend on t_near: else a wall that
    /// was behind the surface could be before it.
    lod::RayLevels<F>* find_levels(const Mask& enters, const F& end) noexcept
    {
        const F zero = 0.0f;
        F in = zero - ray_.shift - abs(ray_.shift) * F(4 * FLT_EPSILON), out = end;
        clip(ray_, state_.frame.diced_bounds, in, out);
        const Mask sees_levels = enters & (in <= out);
        lod::RayLevels<F>* const levels = none(sees_levels)
                                              ? party_.find_levels(enters, ray_.shift + begin_, ray_.shift + end)
                                              : party_.find_levels(sees_levels, ray_.shift + in, ray_.shift + out);
        if (levels) levels->note_reach(sees_levels, ray_.shift + in, ray_.shift + out);
        return levels;
    }

    /// Returns the ends of the rays, widened, as t of the tree's frame.
    OCCAM_ALWAYS_INLINE F limit() const noexcept
    {
        const F t_far = party_.t_far();
        return t_far - ray_.shift + (abs(t_far) + abs(ray_.shift)) * F(4 * FLT_EPSILON);
    }

    /// Returns which rays are inside the bounds somewhere before `far`, which is limit().
    template <class Bounds>
    OCCAM_ALWAYS_INLINE Mask enter(const Bounds& bounds, const F& far) const noexcept
    {
        F in = begin_, out = far;
        if constexpr (!std::is_same_v<Bounds, GridBounds>) {
            bounds.clip_to(ray_, in, out);
            const Mask inside = in <= out;
            return !bounds.slab || none(inside) ? inside : Mask(inside & crosses(ray_, *bounds.slab, in, out));
        } else {
            clip(ray_, bounds.box, in, out);
            const Mask inside = in <= out;
            return none(inside) ? inside : Mask(inside & crosses(ray_, bounds.slab, in, out));
        }
    }

    /// Intersects rays with the igrids that a node holds for these pairs.
    template <class NodeOf>
    OCCAM_ALWAYS_INLINE LeafResult meet_leaf(NodeOf node, Mask alive, F near, F far, PairRange range, const Times& times)
    {
        TreeLeaf& latest = tree_.latest_leaf(node);
        int finest = range.finest, coarsest = range.coarsest;
        const auto is_one = [&] { return finest == coarsest || (latest.pairs.has(finest) && latest.pairs.has(coarsest)); };
        if (!is_one()) pairs_.narrow(alive, near, far, finest, coarsest);
        const auto rays_of = [&](int low, int high) {
            return alive & (max(near, pairs_.in(low, high)) <= min(far, pairs_.out(low, high)));
        };
        for (int pair = finest; pair <= coarsest; ++pair) {
            Mask here = alive;
            if (!is_one()) here = rays_of(pair, pair);
            if (none(here)) continue;
            TreeLeaf* leaf = latest.pairs.has(pair) ? &latest : tree_.leaf(node, pair);
            if (!leaf) return LeafResult::Expanded;
            // A leaf that is the same for several pairs is tested once for all of them.
            const int last = std::min(leaf->pairs.coarsest, coarsest);
            if (pair == finest && last == coarsest) here = alive;
            else if (last > pair) here = rays_of(pair, last);
            if (!meet_entries(*leaf, pair, here, times)) return LeafResult::Abandoned;
            pair = last;
        }
        return state_.is_within(memory_bytes_) ? LeafResult::Done : LeafResult::Abandoned;
    }

    /// Returns the boxes of a group that the rays `here` may enter. Where few rays of a packet are left, each is tested
    /// against all boxes by itself: taken as one with the others it would enter most of them.
    template <class Group>
    OCCAM_ALWAYS_INLINE unsigned in_boxes_of(const Group& group, const Mask& here, const F& far, float* begin) const noexcept
    {
        if constexpr (kIsOne) return group.in_boxes(as_one_, far, begin);
        else {
            if (const unsigned few = group.few(); few != 0) return few;
            unsigned left = bits(here);
            if (std::popcount(left) > kFewRays) return group.in_boxes(as_one_, highest(far), nullptr);
            unsigned maybe = 0;
            for (; left != 0; left &= left - 1) {
                const int lane = std::countr_zero(left);
                maybe |= group.in_boxes_of_lane(RaysAsOne<float>(ray_, lane, begin_), lane, lane_of(far, lane));
            }
            return maybe;
        }
    }

    /// Intersects rays with the igrids of a leaf whose boxes they enter. Returns false if the memory is used up.
    OCCAM_ALWAYS_INLINE bool meet_entries(const TreeLeaf& leaf, int pair, const Mask& here, const Times& times)
    {
        if constexpr (Times::kMoves && !kIsOne) ++state_.visits.leaves;
        F far = limit();
        for (std::size_t first = 0; first < leaf.entries.size(); first += kBoxGroup) {
            if (first % kEntriesBetweenChecks == kEntriesBetweenChecks - kBoxGroup) throw_if_cancelled();
            alignas(32) float begin[kBoxGroup];
            const LeafGroup<F, Times> group(leaf, first, times, std::is_same_v<Tree, Bvh>, !state_.gate);
            unsigned maybe = in_boxes_of(group, here, far, begin);
            while (maybe != 0) {
                int next = std::countr_zero(maybe);
                maybe &= maybe - 1;
                if constexpr (kIsOne) {
                    // A single ray is tested against the igrids in the order in which it enters them.
                    const int lowest_number = next;
                    for (unsigned others = maybe; others != 0; others &= others - 1)
                        if (const int other = std::countr_zero(others); begin[other] < begin[next]) next = other;
                    if (next != lowest_number) maybe ^= 1u << next | 1u << lowest_number;
                    if (!(begin[next] <= far)) break;
                }
                const std::size_t number = first + static_cast<std::size_t>(next);
                const TreeLeaf::Entry& entry = leaf.entries[number];
                const auto enter = [this](const auto& bounds, const F& before) __attribute__((always_inline))
                {
                    return this->enter(bounds, before);
                };
                const Mask entering = here & group.enter(enter, next, far, read_published(entry.grid) ? &entry : nullptr);
                if (none(entering)) continue;
                if (!read_published(entry.grid) && !may_see(entry, entering)) continue;  // what no ray sees is not diced
                IGrid* const grid = state_.grid_of(leaf, number, pair, memory_bytes_);
                if (!grid) return false;
                meet(*grid, entering);
                far = limit();
            }
        }
        return true;
    }

    /// Returns whether any of the rays `entering` may see an entry at its time.
    bool may_see(const TreeLeaf::Entry& entry, const Mask& entering) const noexcept
    {
        if (entry.visible_in == lod::PosedCage::kAllSegments) return true;
        using Moving = RayTimes<F>;
        return any(entering & times_of<Moving>(party_.rays(), std::max(state_.frame.segments, 1)).are_in(entry.visible_in));
    }

    OCCAM_ALWAYS_INLINE void meet(IGrid& grid, Mask entering)
    {
        const auto fresh = party_.note_visit(state_.mailboxes.of(grid), state_.visit, grid, entering);
        if (!fresh) return;
        if constexpr (Times::kMoves) count_visit(fresh);
        if (grid.cage != here_) {
            here_ = grid.cage;
            blended_ = lod::kNoPair;
            party_.place_at(*here_);
        }
        F from = party_.t_near(), to = FLT_MAX;
        if (pairs_.levels && (!pairs_.are_all_in(grid.pairs) || grid.blends())) {
            lod::RayLevels<F>& levels = *pairs_.levels;
            levels.make();
            from = max(from, levels.begin(grid.pairs.finest, grid.pairs.coarsest));
            to = levels.end(grid.pairs.finest, grid.pairs.coarsest);
            if (grid.blends() && blended_ != grid.pairs.finest) {
                blended_ = grid.pairs.finest;
                party_.set_blend(levels.blend(blended_));
            }
        }
        party_.meet(grid, fresh, entering, from, to);
    }

    /// Counts that rays meet an igrid.
    OCCAM_ALWAYS_INLINE void count_visit([[maybe_unused]] unsigned rays) noexcept
    {
        BatchVisits& counted = state_.visits;
        if constexpr (kIsOne) ++counted.igrids_of_lone_rays;
        else {
            ++counted.igrids;
            counted.rays += static_cast<std::uint64_t>(std::popcount(rays));
        }
    }

    void narrate_start(bool enters)
    {
        Narration* const to = party_.query.narration;
        if (!to) return;
        to->set_shift(ray_.shift);
        if (!enters) to->scene_missed();
    }
    void narrate_levels()
    {
        Narration* const to = party_.query.narration;
        if (!to) return;
        if (pairs_.levels) to->levels(*pairs_.levels);
        else to->one_level_for_all();
    }

    /// The number of a leaf's entries that are met between two looks at the request to stop.
    static constexpr std::size_t kEntriesBetweenChecks = 1024;
    /// The number of rays up to which each is tested against the boxes of a leaf by itself.
    static constexpr int kFewRays = 6;

    State& state_;
    Party& party_;
    const TreeRay<F>& ray_;
    const std::size_t memory_bytes_;
    Tree& tree_;
    F begin_;
    RaysAsOne<F> as_one_;
    PairSpans<F> pairs_;
    const lod::PosedCage* here_ = nullptr;  ///< the cage at which the rays are placed
    int blended_ = lod::kNoPair;            ///< the pair whose blend the rays have there
};

}  // namespace occam::accel
