// What a Tracer holds, and how its rays, in packets or one by one, go through the tree.
#pragma once

#include <algorithm>
#include <memory>

#include "accel/frame_state.h"
#include "accel/lazy_tree.h"
#include "accel/leaf_boxes.h"
#include "accel/mailboxes.h"
#include "accel/packet.h"
#include "accel/ray_groups.h"
#include "accel/traverse.h"

namespace occam::accel {

struct Tracer::State {
    explicit State(std::unique_ptr<LazyTree> tree_of_its_own) : State(*tree_of_its_own) { own = std::move(tree_of_its_own); }
    explicit State(LazyTree& all)
        : lazy(all),
          frame(all.frame),
          budget(all.budget),
          arena(all.arena),
          tree(all.tree),
          gate(all.gate()),
          mailboxes(gate != nullptr)
    {
    }

    /// `seen`: the gate's flushes before it was found that there is too little room.
    void flush(std::uint64_t seen)
    {
        if (gate) gate->flush(seen, [&] { lazy.flush(); });
        else lazy.flush();
    }

    enum class PacketResult : unsigned char {
        Done,
        Abandoned,  ///< the budget was passed on the way
        TooWide     ///< the rays see too many pairs of levels to travel together
    };
    /// One group of rays with equal axes and octant.
    template <int kParts, class Found>
    PacketResult run_packet(std::span<const Ray> rays, const RayAxes& axes, std::size_t limit_bytes,
                            PacketQuery<Found, kParts>& query);
    /// False if the budget was passed on the way.
    template <class Found>
    bool run_single(const Ray& ray, const RayAxes& axes, std::size_t limit_bytes, SingleQuery<Found>& query);

    template <class F, class Limit, class Enter, class Meet>
    LeafResult meet_leaf(std::uint32_t node, MaskOf<F> alive, F t_near, F t_far, const PairSpans<F>& pairs, int finest,
                         int coarsest, std::size_t limit_bytes, const RaysAsOne<F>& as_one, Limit&& limit, Enter&& enter,
                         Meet&& meet);
    /// The igrid of an entry, made if need be; null: the budget is passed.
    IGrid* grid_of(const KdLeaf& leaf, std::size_t number, int pair, std::size_t limit_bytes)
    {
        if (IGrid* known = read_published(leaf.entries[number].grid)) return known;
        IGrid* made = &lazy.grid(leaf, number, pair, counters.diced);
        return arena.bytes() <= limit_bytes ? made : nullptr;
    }
    bool is_per_ray() const noexcept { return frame.levels.mode != lod::LevelMode::PerInstance; }
    /// Makes the table of transitions of a packet of which `enters` are in the scene from t_in to t_out; false if its rays
    /// see too many pairs to travel together.
    template <int kParts>
    bool fits_packet(std::span<const Ray> rays, const vmasks<kParts>& enters, const vfloats<kParts>& t_in,
                     const vfloats<kParts>& t_out) noexcept;
    template <int kParts>
    lod::RayLevels<vfloats<kParts>>& packet_levels() noexcept
    {
        if constexpr (kParts == 1) return narrow_levels;
        else return wide_levels;
    }
    /// What a ray's table of transitions is made of, but for where it is in the scene.
    struct Reach {
        lod::Footprint wanted;
        float coordinate;  ///< the largest that the ray's arithmetic meets
        float start;       ///< edge length of the ray's start level; 0: it has none
    };
    Reach reach_of(const Ray& ray) const noexcept
    {
        return {wanted_of(ray, frame.levels),
                std::max(static_cast<float>(glm::distance(ray.origin, frame.anchor)), frame.radius),
                ray.start_level == kAnyLevel ? 0.0f : lod::edge_length(ray.start_level)};
    }

    template <int kParts, class Found, class Take>
    PacketResult run_packet_of(std::span<const Ray> rays, const RayAxes& axes, std::size_t first, std::size_t limit_bytes,
                               Take&& take);
    /// Traces one group, and gives take(i, lane, found, blends) what its ray i has met: lane of found; blends(pair, lane):
    /// how it blends.
    template <class Found, class Take>
    bool run(const RayAxes& axes, std::size_t first, std::size_t count, std::size_t limit_bytes, Take&& take);
    /// fill(axes, first, met) for each group: what groups.sorted[first + i] has met, and, if kWithBlend, how it blends
    /// there.
    template <bool kWithBlend, class Fill>
    void find_nearest(std::span<const Ray> rays, Fill&& fill);

    /// Traces rays[first, first + count) by `run(first, count, limit)`, flushing and halving as the budget asks.
    template <class Run>
    void within_budget(std::size_t first, std::size_t count, Run&& run)
    {
        const auto fits = [&] {
            if (gate) gate->pass();
            const std::uint64_t seen = gate ? gate->flushes() : 0;
            if (run(first, count, budget)) return true;
            flush(seen);
            return false;
        };
        // Abandoned: what was built is dropped, and the same rays start again in an empty arena, at last one by one.
        if (fits() || fits()) return;
        if (count == 1) {
            run(first, 1, ~std::size_t(0));
            return;
        }
        within_budget(first, count / 2, run);
        within_budget(first + count / 2, count - count / 2, run);
    }

    /// Calls run(axes, first, count, limit) for runs of groups.sorted that may travel together.
    template <class Run>
    void for_groups(std::span<const Ray> rays, Run&& run)
    {
        groups.sort(rays);
        const FlushGate::Inside inside(gate);
        groups.for_each_packet([&](const RayAxes& axes, std::size_t first, std::size_t count) {
            within_budget(first, count, [&](std::size_t from, std::size_t of_these, std::size_t limit) {
                return run(axes, from, of_these, limit);
            });
        });
        counters.rays += rays.size();
    }

    std::unique_ptr<LazyTree> own;  ///< null: the tree is shared
    LazyTree& lazy;
    const FrameState& frame;
    const std::size_t budget;
    Arena& arena;
    KdTree& tree;
    FlushGate* const gate;   ///< null unless the tree is shared
    TraceCounters counters;  ///< without those of building
    Mailboxes mailboxes;
    lod::RayLevels<vfloats<1>> narrow_levels;  ///< of the packet traced last
    lod::RayLevels<vfloats<2>> wide_levels;
    lod::RayLevels<float> single_levels;  ///< of the ray traced last
    RayGroups groups;                     ///< of the batch traced last
    std::uint64_t visit = 0;
};

}  // namespace occam::accel
