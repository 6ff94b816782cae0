#include "accel/lazy_tree.h"

#include <algorithm>

#include "accel/memory_floor.h"
#include "base/error_without_file.h"

namespace occam::accel {

LazyTree::LazyTree(const FrameState& f, std::size_t bytes, BuildTechniques with, bool is_shared)
    : frame(f),
      memory_bytes(bytes),
      least_bytes(std::min(bytes, memory_floor(*f.scene))),
      techniques(with),
      sharing(is_shared ? std::make_unique<Sharing>() : nullptr),
      items(f, arena, dicer, counters, with.spatial),
      kd(items, arena, counters, with.scan, building()),
      bvh(items, arena, counters, f.segments, building())
{
    restart();
}

std::size_t LazyTree::allowed_bytes() const noexcept
{
    constexpr double kTables = double(std::size_t(4) << 30);
    const double share = std::max(0.5, 1 - double(frame.topologies->class_bytes()) / kTables);
    return std::max(least_bytes, static_cast<std::size_t>(double(memory_bytes) * share));
}

void LazyTree::flush()
{
    counters.peak_bytes = std::max(counters.peak_bytes, arena.bytes());
    ++counters.flushes;
    effort.add_flush(arena.bytes());
    if (frame.refuses_endless) refuse_if_hopeless();
    restart();
}

void LazyTree::refuse_if_hopeless() const
{
    if (!effort.is_hopeless()) return;
    throw error_without_file(
        std::to_string(effort.rays()) + " rays met " + std::to_string(effort.bytes() >> 30) +
            " GB of surfaces, again and again more than the memory budget holds, so this would not end; "
            "larger micropolygons (the shading rate), a smaller displacement" +
            (frame.holds_swept() ? ", the tree of boxes (bvh)" : "") + " or a larger memory budget help",
        items.name_of_largest());
}

void LazyTree::restart()
{
    arena.reset(allowed_bytes());
    dicer.forget();
    const ItemIndex root = items.restart();
    std::vector<ItemIndex> roots{root};
    if (!techniques.hierarchy) roots = items.base_patches();
    if (frame.tree == TreeKind::Bvh) {
        bvh.restart(roots);
        if (!techniques.lazy) bvh.expand_all(lod::kCoarsestLevel);
    } else {
        kd.restart(frame.bounds, roots);
        if (!techniques.lazy) kd.expand_all(lod::kCoarsestLevel);
    }
}

void LazyTree::tighten(const TreeLeaf& leaf, std::size_t place, const IGrid& grid) const
{
    Box3f boxes[lod::kMostSegments + 1];
    GrowthAtKeys growth;  // boxes are rounded twice, as in Bvh
    float area = 0, area_of_item = 0;
    for (int key = 0; key <= leaf.keys.segments; ++key) {
        const Box3f box = items.box_at(grid, leaf.keys.begin + static_cast<float>(key) / leaf.keys.per_time);
        if (box.is_empty()) return;
        const Vec3f pad(growth.next(box));
        boxes[key] = {box.lo - pad, box.hi + pad};
        area += boxes[key].half_area();
        area_of_item +=
            get_box(leaf.boxes + static_cast<std::size_t>(key) * leaf.stride(), place, leaf.keys.row).half_area();
    }
    if (!(area < area_of_item)) return;
    for (int key = 0; key <= leaf.keys.segments; ++key)
        set_box(leaf.boxes + static_cast<std::size_t>(key) * leaf.stride(), place, boxes[key], leaf.keys.row);
}

IGrid& LazyTree::grid(const TreeLeaf& leaf, std::size_t place, int pair, TraceCounters& asker)
{
    const BuildLock lock(building());
    TreeLeaf::Entry& entry = leaf.entries[place];
    if (entry.grid) return *entry.grid;  // another thread has built it in the meantime
    const std::uint64_t diced = counters.diced, grids = counters.grids;
    IGrid& made = items.grid(entry.item, pair);
    // Whether a surface has a hole is asked in the middle of a traversal, where nothing may be built.
    if (made.may_have_holes && made.is_lattice) shade_parts(made.lattice(), {frame, dicer, arena, counters, nullptr});
    asker.diced += counters.diced - diced;
    asker.grids += counters.grids - grids;
    entry.bounds = items.bounds_of(made);
    // Other threads may be reading the boxes of a shared tree.
    if (!sharing) {
        if (leaf.keys.segments == 0) set_box(leaf.boxes, place, entry.bounds.box);
        else tighten(leaf, place, made);
    }
    publish(entry.grid, &made);
    return made;
}

TraceCounters LazyTree::totals()
{
    const MaybeLock lock(sharing ? &sharing->building.mutex : nullptr);
    TraceCounters all = counters;
    all.peak_bytes = std::max(all.peak_bytes, arena.bytes());
    all.vertices_diced = dicer.vertices_diced();
    all.vertices_shaded = dicer.vertices_shaded();
    return all;
}

}  // namespace occam::accel
