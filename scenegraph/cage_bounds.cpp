// The bounds of cages: the vertices that some face has count, at all keys of the shutter.
#include "scenegraph/scene_state.h"

namespace occam {

Box3d box_of_used(const CageSlot& slot, std::span<const Vec3f> positions) noexcept
{
    Box3d box;
    std::size_t v = 0;
    const auto add_until = [&](std::size_t end) {
        for (; v < end; ++v) box.add(Vec3d(positions[v]));
    };
    for (const std::uint32_t unused : slot.unused_vertices) {
        add_until(unused);
        ++v;
    }
    add_until(positions.size());
    return box;
}

std::vector<std::uint32_t> find_unused_vertices(const Cage& cage)
{
    std::vector<bool> is_used(cage.positions.size());
    for (const std::uint32_t v : cage.face_vertices) is_used[v] = true;
    std::vector<std::uint32_t> unused;
    for (std::uint32_t v = 0; v < is_used.size(); ++v)
        if (!is_used[v]) unused.push_back(v);
    return unused;
}

void find_bounds(CageSlot& slot)
{
    // What needs memory comes first.
    auto deform = decltype(slot.deform)();
    if (slot.cage.skin.sets > 0 || !slot.cage.morph_targets.empty()) deform.add_all(slot.cage, slot.unused_vertices);
    slot.key_bounds.reserve(slot.key_positions.size());
    slot.bounds = grown_by_displacement(slot.cage, box_of_used(slot, slot.cage.positions));
    slot.key_bounds.clear();
    for (const std::vector<Vec3f>& positions : slot.key_positions) {
        slot.key_bounds.push_back(grown_by_displacement(slot.cage, box_of_used(slot, positions)));
        slot.bounds.add(slot.key_bounds.back());
    }
    slot.deform = std::move(deform);
}

}  // namespace occam
