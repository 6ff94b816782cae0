#include "accel/phase_one.h"

#include <algorithm>

#include "base/publish.h"
#include "base/stopwatch.h"

namespace occam::accel {

// This is kept out of line because it is rare.
OCCAM_NEVER_INLINE void shade_part(const IGrid& grid, IGridPart& part, const PhaseOneTools& tools)
{
    const BuildLock lock(tools.building);
    if (part.is_shaded) return;  // another thread has shaded it in the meantime
    const Stopwatch watch(tools.counters.shade_seconds);
    part.attributes = tools.dicer.shade(*grid.cage, part.tile, grid.blends() ? part.coarser() : part.tile.rates,
                                        tools.arena);
    part.material = material_of(*tools.frame.scene, *grid.cage, part.tile.patch.face);
    publish(part.is_shaded, true);
}

const Material* material_of(const Scene& scene, const lod::PosedCage& cage, std::uint32_t face) noexcept
{
    static const Material plain;
    const Cage& source = cage.slot->cage;
    const std::size_t slot = source.face_slots.empty() ? 0 : source.face_slots[face];
    const auto& from = cage.node->materials.empty() ? source.materials : cage.node->materials;
    const Material* found = slot < from.size() ? scene.find(from[slot]) : nullptr;
    return found ? found : &plain;
}

const Material* common_material(const Scene& scene, const lod::PosedCage& cage,
                                std::span<const std::uint32_t> faces) noexcept
{
    const Material* const first = material_of(scene, cage, faces.front());
    if (cage.slot->cage.face_slots.empty()) return first;
    const bool is_common = std::ranges::all_of(faces,
                                               [&](std::uint32_t face) { return material_of(scene, cage, face) == first; });
    return is_common ? first : nullptr;
}

void shade_parts(LatticeGrid& grid, const PhaseOneTools& tools)
{
    for (IGridPart& part : grid.parts)
        if (!read_published(part.is_shaded)) shade_part(grid, part, tools);
}

}  // namespace occam::accel
