// Holds a tree with everything that it is made of. It belongs to one worker or is shared by a group of workers.
//
// A shared tree is read without a lock; what makes it grow (expanding a node, dicing an igrid, shading one) happens
// under one lock. It is dropped when all workers are at a safe point between two groups of rays.
//
// Memory   Its own arena.
// Threads  One thread, or those that enter through its gate.
#pragma once

#include <memory>

#include "accel/build_effort.h"
#include "accel/build_lock.h"
#include "accel/build_techniques.h"
#include "accel/bvh.h"
#include "accel/flush_gate.h"
#include "accel/kd_tree.h"
#include "accel/phase_one.h"

namespace occam::accel {

struct LazyTree {
    LazyTree(const FrameState& frame, std::size_t memory_bytes, BuildTechniques techniques, bool is_shared);

    /// Returns how many bytes the arena may take now. The tables of subdivision cages are not part of the budget, but where
    /// they take gigabytes the arena gets less: half of the budget at worst, and never less than any ray needs.
    std::size_t allowed_bytes() const noexcept;
    /// Drops everything. No other thread may be inside the gate. Throws Error if the frame would not end.
    void flush();
    /// Returns the igrid of a leaf's entry. It is built now if this is the first ray that enters its box.
    /// asker   counts what is built now: only `grids` and `diced`
    IGrid& grid(const TreeLeaf& leaf, std::size_t place, int pair, TraceCounters& asker);
    PhaseOneTools phase_one() noexcept { return {frame, dicer, arena, counters, building()}; }
    /// Returns what building has cost so far.
    TraceCounters totals();

    /// Replaces the boxes of an entry at the keys of a leaf by those of its igrid, where these are smaller.
    void tighten(const TreeLeaf& leaf, std::size_t place, const IGrid& grid) const;

    struct Sharing {
        Building building;
        FlushGate gate;
    };
    template <class Tree>
    Tree& tree() noexcept
    {
        if constexpr (std::is_same_v<Tree, Bvh>) return bvh;
        else return kd;
    }
    Building* building() const noexcept { return sharing ? &sharing->building : nullptr; }
    FlushGate* gate() const noexcept { return sharing ? &sharing->gate : nullptr; }

    /// Starts with an empty tree.
    void restart();
    void refuse_if_hopeless() const;

    const FrameState& frame;
    const std::size_t memory_bytes, least_bytes;
    const BuildTechniques techniques;
    const std::unique_ptr<Sharing> sharing;  ///< null if the tree belongs to one worker
    Arena arena;
    lod::Dicer dicer;
    TraceCounters counters;
    BuildEffort effort;
    Items items;
    /// Only the tree that the frame names is in use.
    KdTree kd;
    Bvh bvh;
};

}  // namespace occam::accel
