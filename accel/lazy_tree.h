// A kd-tree with all that it is made of: one worker's own, or shared by a group of workers.
//
// Shared, it is read without a lock; what grows it (expanding a node, dicing an igrid, shading one) does so under one lock.
// It is dropped with all workers at a safe point between two groups of rays.
//
// Memory   its arena.   Threads  one, or those who come through its gate.
#pragma once

#include <memory>
#include <mutex>

#include "accel/flush_gate.h"
#include "accel/hit.h"
#include "accel/kd_tree.h"

namespace occam::accel {

struct LazyTree {
    LazyTree(const FrameState& frame, std::size_t budget_bytes, BuildTechniques techniques, bool is_shared);

    /// Drops everything. Nobody else is inside.
    void flush();
    /// The igrid of an entry of a leaf, built now if this is the first ray that enters its box.
    /// diced   what is diced now is added to it, as TraceCounters::diced counts
    IGrid& grid(const KdLeaf& leaf, std::size_t place, int pair, std::uint64_t& diced);
    PhaseOneTools phase_one() noexcept { return {frame, dicer, arena, counters, building()}; }
    /// What building has cost so far.
    TraceCounters totals();

    struct Sharing {
        std::mutex building;
        FlushGate gate;
    };
    std::mutex* building() const noexcept { return sharing ? &sharing->building : nullptr; }
    FlushGate* gate() const noexcept { return sharing ? &sharing->gate : nullptr; }

    const FrameState& frame;
    const std::size_t budget;
    const BuildTechniques techniques;
    const std::unique_ptr<Sharing> sharing;  ///< null: one worker's own
    Arena arena;
    lod::Dicer dicer;
    TraceCounters counters;
    Items items;
    KdTree tree;
};

}  // namespace occam::accel
