#include "lod/pose_cage.h"

#include <algorithm>

#include "lod/level_choice.h"

namespace occam::lod {

PosedCage& pose_cage(const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools)
{
    const auto& [slot, node, node_id, skin, matrices, shutter_segments, seen_by, lit_by, visible_in, path,
                 instance] = placement;
    PosedCage& cage = *tools.arena.make<PosedCage>();
    cage.slot = &slot;
    cage.topology = tools.tables.topology.get();
    cage.clusters = tools.tables.clusters.get();
    cage.node = &node;
    cage.node_id = node_id;
    cage.instance = instance;
    cage.cage_id = slot.id;
    cage.seen_by = seen_by;
    cage.lit_by = lit_by;
    cage.visible_in = visible_in;
    cage.path = path;
    const bool chooses_level = cage.topology && levels.mode == LevelMode::PerInstance;
    const CageMotion motion(slot, node, skin, matrices, shutter_segments);
    if (motion.moves()) {
        // Boxes of nodes that stand still hold only what moves in them at keys where it is visible.
        const int segments = visible_in == PosedCage::kAllSegments
                                 ? motion.segments(motion_tolerance(levels, motion.world_box()))
                                 : shutter_segments;
        if (cage.topology) cage.least_level = level_of_motion(levels, motion);
        PosedCage& first = motion.make_keys(cage, segments, tools);
        if (chooses_level) {
            first.level = kCoarsestLevel;
            for (int k = 0; k <= segments; ++k) first.level = std::min(first.level, choose_level(levels, first.keys[k]));
        }
        return first;
    }
    cage.place(matrices.front(), cage_bounds(node, slot, skin));
    if (tools.tables.deformed_clusters)
        cage.deform(*tools.tables.deformed_clusters, {slot, node, skin}, tools.arena, tools.counters);
    if (tools.textures) cage.displace(*tools.textures);
    cage.derive(tools.arena);
    if (chooses_level) cage.level = choose_level(levels, cage);
    return cage;
}

}  // namespace occam::lod
