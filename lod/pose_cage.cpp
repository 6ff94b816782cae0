#include "lod/pose_cage.h"

#include <algorithm>

#include "lod/level_choice.h"

namespace occam::lod {

namespace {

/// Returns a cage that knows what it shows and how fast it moves, but not where it is.
PosedCage& named_cage(const CagePlacement& placement, const CageMotion& motion, const LevelSettings& levels,
                      const PosingTools& tools)
{
    PosedCage& cage = *tools.arena.make<PosedCage>();
    cage.slot = &placement.slot;
    cage.topology = tools.tables.topology.get();
    cage.clusters = tools.tables.clusters.get();
    cage.node = &placement.node;
    cage.node_id = placement.node_id;
    cage.instance = placement.instance;
    cage.cage_id = placement.slot.id;
    cage.seen_by = placement.seen_by;
    cage.lit_by = placement.lit_by;
    cage.visible_in = placement.visible_in;
    cage.path = placement.path;
    if (motion.moves() && cage.topology) cage.least_level = level_of_motion(levels, motion, tools.tables.curvature);
    return cage;
}

bool chooses_level(const PosedCage& cage, const LevelSettings& levels) noexcept
{
    return cage.topology && levels.mode == LevelMode::PerInstance;
}

/// Sets the levels of a cage that is posed, at its first key if it moves.
PosedCage& with_levels(PosedCage& first, const LevelSettings& levels)
{
    if (first.topology) first.least_level = std::max(first.least_level, level_of_boxes(levels, first));
    if (chooses_level(first, levels)) first.level = std::min(kCoarsestLevel, choose_level(levels, first));
    return first;
}

/// Poses a cage that moves, for all times of the shutter.
PosedCage& pose_moving(const CageMotion& motion, const PosedCage& cage, const CagePlacement& placement,
                       const LevelSettings& levels, const PosingTools& tools)
{
    // Boxes of nodes that stand still hold only what moves in them at keys where it is visible.
    const int segments = placement.visible_in == PosedCage::kAllSegments
                             ? motion.segments(motion_tolerance(levels, motion.world_box()))
                             : placement.segments;
    return with_levels(motion.make_keys(cage, segments, tools), levels);
}

PosedCage& pose_still(PosedCage& cage, const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools)
{
    cage.place(placement.world_from_node.front(), cage_bounds(placement.node, placement.slot, placement.skin));
    cage.longest_at_poles = static_cast<float>(
        longest_pole_edge(placement.node, placement.slot, placement.skin, Mat3d(placement.world_from_node.front())));
    if (tools.tables.deformed_clusters)
        cage.deform(*tools.tables.deformed_clusters, {placement.slot, placement.node, placement.skin}, tools.arena,
                    tools.counters);
    if (tools.textures) cage.displace(*tools.textures);
    cage.derive(tools.arena);
    return with_levels(cage, levels);
}

CageMotion motion_of(const CagePlacement& placement)
{
    return {placement.slot, placement.node, placement.skin, placement.world_from_node, placement.segments};
}

}  // namespace

PosedCage& pose_cage(const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools)
{
    const CageMotion motion = motion_of(placement);
    PosedCage& cage = named_cage(placement, motion, levels, tools);
    if (!motion.moves()) return pose_still(cage, placement, levels, tools);
    return pose_moving(motion, cage, placement, levels, tools);
}

void for_each_size(const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools,
                   const std::function<void(const PosedCage&)>& visit)
{
    const CageMotion motion = motion_of(placement);
    PosedCage& cage = named_cage(placement, motion, levels, tools);
    if (!motion.moves()) return visit(pose_still(cage, placement, levels, tools));
    if (motion.segments_by_size(placement.segments).size() < 2)
        return visit(pose_moving(motion, cage, placement, levels, tools));
    // Where the cage is small, its path is followed as closely as its size there asks for.
    const int segments = placement.visible_in == PosedCage::kAllSegments
                             ? motion.segments([&](int key) { return motion_tolerance(levels, motion.world_box_at(key)); })
                             : placement.segments;
    const std::vector<std::uint32_t> groups = motion.segments_by_size(segments);
    if (groups.size() < 2) return visit(with_levels(motion.make_keys(cage, segments, tools), levels));
    for (const std::uint32_t shown : groups)
        if (shown & placement.visible_in) visit(with_levels(motion.make_keys_in(cage, shown, segments, tools), levels));
}

}  // namespace occam::lod
