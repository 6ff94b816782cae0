// Holds the state of a Tracer, and traces its rays through the tree in packets or one by one.
#pragma once

#include <algorithm>
#include <memory>

#include "accel/bvh_traverse.h"
#include "accel/frame_state.h"
#include "accel/lazy_tree.h"
#include "accel/mailboxes.h"
#include "accel/memory_floor.h"
#include "accel/packet.h"
#include "accel/ray_groups.h"
#include "accel/ray_reach.h"
#include "accel/time_order.h"
#include "accel/tracer.h"
#include "accel/traverse.h"
#include "base/cancellation.h"
#include "base/error_without_file.h"

namespace occam::accel {

/// Names the tree that rays walk through, and what it knows of their times. Items in the kd-tree have boxes for all times.
struct InKdTree {
    using Tree = KdTree;
    template <class F>
    using Times = NoTimes;
};
struct InBvh {
    using Tree = Bvh;
    template <class F>
    using Times = NoTimes;
};
struct InMovingBvh {
    using Tree = Bvh;
    template <class F>
    using Times = RayTimes<F>;
};

struct Tracer::State {
    explicit State(std::unique_ptr<LazyTree> tree_of_its_own) : State(*tree_of_its_own) { own = std::move(tree_of_its_own); }
    explicit State(LazyTree& all)
        : lazy(all), frame(all.frame), arena(all.arena), gate(all.gate()), mailboxes(gate != nullptr)
    {
    }

    /// Drops everything that was built, unless another worker of the tree has done so since the gate's number of flushes
    /// was `seen`.
    void flush(std::uint64_t seen)
    {
        if (gate) gate->flush(seen, [&] { lazy.flush(); });
        else lazy.flush();
    }

    enum class PacketResult : unsigned char {
        Done,
        Abandoned,  ///< the budget was exceeded during the trace
        TooWide     ///< the rays see too many pairs of levels to travel together
    };
    /// Traces one packet of rays with equal axes and octant through the frame's tree, as Way names it.
    template <class Way, int kParts, class Found>
    PacketResult run_packet(std::span<const Ray> rays, const RayAxes& axes, std::size_t memory_bytes,
                            PacketQuery<Found, kParts>& query);
    /// Traces one ray. Returns false if the budget was exceeded during the trace.
    template <class Way, class Found>
    bool run_single(const Ray& ray, const RayAxes& axes, std::size_t memory_bytes, SingleQuery<Found>& query);

    /// Returns whether each ray of a group is traced alone. In the tree of boxes this is faster where rays go different
    /// ways, since they do not share the boxes of its nodes (docs/performance.md). `is_nearest` tells rays that look for
    /// their nearest hits from those that end at any.
    bool travel_alone(std::span<const Ray> rays, bool is_nearest) const noexcept;
    /// Calls call(way) with what names the tree of the frame.
    template <class Call>
    auto in_tree(Call&& call)
    {
        if (frame.tree == TreeKind::Kd) return call(InKdTree());
        return frame.segments > 0 ? call(InMovingBvh()) : call(InBvh());
    }

    /// Takes rays through a tree (accel/walk.h).
    template <class Way, class Party>
    class Walk;
    /// Returns whether what is built fits the memory budget.
    bool is_within(std::size_t memory_bytes) const noexcept { return arena.bytes() <= memory_bytes; }
    /// Returns the igrid of an entry, which is built if needed, or null if the budget is exceeded.
    IGrid* grid_of(const TreeLeaf& leaf, std::size_t number, int pair, std::size_t memory_bytes)
    {
        if (IGrid* known = read_published(leaf.entries[number].grid)) return known;
        IGrid* made = &lazy.grid(leaf, number, pair, counters);
        return is_within(memory_bytes) ? made : nullptr;
    }
    /// Clears a query before its rays are traced.
    template <class Query>
    void prepare(Query& query, std::span<const Ray> rays, const Holes& holes) const noexcept
    {
        start(query, rays);
        set_wishes(query, holes);
    }
    /// Tells a query which holes rays pass, and how many hits of each ray are wanted.
    template <class Query>
    void set_wishes(Query& query, const Holes& holes) const noexcept
    {
        query.holes = &holes;
        if constexpr (std::is_base_of_v<NearestSome, Query>) query.wanted = wanted_hits;
    }
    template <int kParts>
    lod::RayLevels<vfloats<kParts>>& packet_levels() noexcept
    {
        if constexpr (kParts == 1) return narrow_levels;
        else return wide_levels;
    }
    template <int kParts, class Found, class Take>
    PacketResult run_packet_of(std::span<const Ray> rays, const RayAxes& axes, std::size_t first, std::size_t memory_bytes,
                               Take&& take);
    /// Traces the rays groups.sorted[first, first + count), which share their axes, in packets or one by one. Calls
    /// take(i, lane, found, blends) for each ray first + i, whose hit is in `lane` of found. blends(pair, lane) returns the
    /// ray's blend in that pair. Returns false if the budget was exceeded.
    template <class Found, class Take>
    bool run(const RayAxes& axes, std::size_t first, std::size_t count, std::size_t memory_bytes, Take&& take);
    /// Finds the nearest hits and calls fill(axes, first, met) for each group: met[i] holds what groups.sorted[first + i]
    /// has hit and, if kWithBlend is set, how it blends there. Calls expect(i) for each ray of the caller's batch before it
    /// is traced.
    template <bool kWithBlend, class Expect, class Fill>
    void find_nearest(std::span<const Ray> rays, Expect&& expect, Fill&& fill);

    /// Traces rays[first, first + count) by `run(first, count, memory_bytes)`, flushing as the budget requires.
    template <class Run>
    void within_budget(std::size_t first, std::size_t count, Run&& run)
    {
        const auto fits = [&] {
            if (gate) gate->pass();
            const std::uint64_t seen = gate ? gate->flushes() : 0;
            if (run(first, count, lazy.allowed_bytes())) {
                lazy.effort.add_rays(count);
                return true;
            }
            flush(seen);
            return false;
        };
        // Each time the budget is exceeded everything is dropped and the same rays start again in an empty arena: first
        // all of them once more, then each ray by itself, in the end with more memory, if it needs that. In a shared tree
        // other rays take memory meanwhile; that last time they wait.
        if (fits() || fits()) return;
        if (count == 1) {
            const std::size_t most = std::max(lazy.memory_bytes, kMostBytesOfARay);
            const auto run_alone = [&] { return run(first, 1, most); };
            if (gate ? gate->alone([&] { lazy.flush(); }, run_alone) : run_alone()) return lazy.effort.add_rays(1);
            throw error_without_file(
                "one ray meets more surfaces than fit into " + std::to_string(most >> 20) + " MB" +
                (frame.holds_swept() ? "; in the kd-tree it meets what passes at any time (the tree of boxes, bvh, helps)"
                                     : ""));
        }
        for (std::size_t i = 0; i < count; ++i) within_budget(first + i, 1, run);
    }

    /// Calls run(axes, first, count, memory_bytes) for runs of groups.sorted that may travel together. Throws Cancelled if
    /// the thread is asked to stop.
    template <class Run>
    void for_groups(std::span<const Ray> rays, Run&& run)
    {
        const bool are_of_camera = !rays.empty() && (rays.front().kinds & RayKind::Camera);
        const std::uint64_t diced = counters.diced;
        TimeOrder& order = are_of_camera ? order_of_camera_rays : order_of_other_rays;
        const BatchOrder batch = frame.segments > 0 ? order.next(rays.size()) : BatchOrder{1};
        groups.sort(rays, batch.bins);
        are_all_alone = batch.is_alone;
        visits = {};
        const FlushGate::Inside inside(gate);
        groups.for_each_packet([&](const RayAxes& axes, std::size_t first, std::size_t count) {
            throw_if_cancelled();
            within_budget(first, count, [&](std::size_t from, std::size_t of_these, std::size_t memory_bytes) {
                return run(axes, from, of_these, memory_bytes);
            });
        });
        if (frame.segments > 0) order.note(rays.size(), visits);
        counters.rays += rays.size();
        if (are_of_camera) counters.diced_for_camera += counters.diced - diced;
    }

    std::unique_ptr<LazyTree> own;  ///< null if the tree is shared
    LazyTree& lazy;
    const FrameState& frame;
    Arena& arena;
    FlushGate* const gate;   ///< null unless the tree is shared
    TraceCounters counters;  ///< building is counted in the tree's own counters
    Mailboxes mailboxes;
    lod::RayLevels<vfloats<1>> narrow_levels;  ///< for the packet traced last
    lod::RayLevels<vfloats<2>> wide_levels;
    lod::RayLevels<float> single_levels;  ///< for the ray traced last
    RayGroups groups;                     ///< for the batch traced last
    TimeOrder order_of_camera_rays, order_of_other_rays;
    BatchVisits visits;          ///< of the batch, where something moves
    bool are_all_alone = false;  ///< the batch's rays travel alone
    std::uint64_t visit = 0;
    int wanted_hits = 1;  ///< of each ray, for Tracer::nearest()
};

}  // namespace occam::accel
