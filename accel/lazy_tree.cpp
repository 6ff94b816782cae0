#include "accel/lazy_tree.h"

namespace occam::accel {

LazyTree::LazyTree(const FrameState& f, std::size_t budget_bytes, BuildTechniques with, bool is_shared)
    : frame(f),
      budget(budget_bytes),
      techniques(with),
      sharing(is_shared ? std::make_unique<Sharing>() : nullptr),
      items(f, arena, dicer, counters),
      tree(items, arena, counters, with.scan, building())
{
    flush();
    counters.flushes = 0;
}

void LazyTree::flush()
{
    counters.peak_bytes = std::max(counters.peak_bytes, arena.bytes());
    ++counters.flushes;
    arena.reset(budget);
    dicer.forget();
    const ItemIndex root = items.restart();
    if (techniques.hierarchy) tree.restart(frame.bounds, {&root, 1});
    else tree.restart(frame.bounds, items.base_patches());
    if (!techniques.lazy) tree.expand_all(lod::kCoarsestLevel);
}

IGrid& LazyTree::grid(const KdLeaf& leaf, std::size_t place, int pair, std::uint64_t& diced)
{
    const MaybeLock lock(building());
    KdLeaf::Entry& entry = leaf.entries[place];
    if (entry.grid) return *entry.grid;  // another thread has built it in the meantime
    const std::uint64_t before = counters.diced;
    IGrid& made = items.grid(entry.item, pair);
    diced += counters.diced - before;
    entry.bounds = items.bounds_of(made);
    // Other threads may be reading the boxes of a shared tree.
    if (!sharing) set_box(leaf.boxes, place, entry.bounds.box);
    publish(entry.grid, &made);
    return made;
}

TraceCounters LazyTree::totals()
{
    const MaybeLock lock(building());
    TraceCounters all = counters;
    all.peak_bytes = std::max(all.peak_bytes, arena.bytes());
    all.vertices_diced = dicer.vertices_diced;
    all.vertices_shaded = dicer.vertices_shaded;
    return all;
}

SharedTree::SharedTree(const Frame& frame, std::size_t budget_bytes)
    : tree_(std::make_unique<LazyTree>(frame.state(), budget_bytes, BuildTechniques(), true))
{
}
SharedTree::~SharedTree() = default;
TraceCounters SharedTree::counters() const { return tree_->totals(); }

}  // namespace occam::accel
