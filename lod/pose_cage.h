// Makes a PosedCage whole: placed, deformed and displaced, at every key if it moves while the shutter is open.
//
// Space    the matrices lead to world axes, in the unit of length of the frame.
// Memory   the arena of PosingTools; the result borrows the scene and the topology tables.
// Errors   none: a skin or a displacement that the cage does not have is left out.
#pragma once

#include <functional>

#include "lod/cage_motion.h"

namespace occam::lod {

/// Says which cage is posed, where it is, and which rays see it.
struct CagePlacement {
    const CageSlot& slot;  ///< has its polygons, also if it is made on demand
    const Node& node;      ///< the node that shows the cage
    NodeId node_id;
    const SkinSlot* skin;                    ///< the node's skin, or null
    std::span<const Mat4d> world_from_node;  ///< at each key of the shutter, or once if the placement stands still
    int segments = 0;                        ///< of the scene's shutter; 0: it has none
    std::uint8_t seen_by = RayKind::All;     ///< the fields from here on are as in PosedCage
    LightGroups lit_by = kAllGroups;
    std::uint32_t visible_in = PosedCage::kAllSegments;
    GraphPath path{};
    NodeId instance{};
};

/// Poses the cage. With LevelMode::PerInstance, a cage that is subdivided gets the level that its rays see, which is the
/// finest that it needs while the shutter is open.
PosedCage& pose_cage(const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools);

/// Poses the cage as rays see it, and calls visit(posed): once, unless the cage is much larger in some segments of the
/// shutter than in others. Then it is posed for each size, and each pose is visible in the segments of that size alone.
void for_each_size(const CagePlacement& placement, const LevelSettings& levels, const PosingTools& tools,
                   const std::function<void(const PosedCage&)>& visit);

}  // namespace occam::lod
