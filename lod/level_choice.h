// Chooses the level at which a placement is seen, if all rays of a frame share one.
#pragma once

#include "lod/footprint.h"
#include "lod/posed_cage.h"

namespace occam::lod {

/// Returns the largest level with d_l <= target edge length where and when the camera's footprint on the cage is smallest
/// while the shutter is open: at the nearest cluster in view (or the nearest of all, if none is in view). Next to the eye a
/// cluster counts as an eighth of its radius away, so that nothing is infinitely fine. For each segment of the motion it
/// visits the clusters nearer than the nearest, usually O(log n).
/// cage   with all of its keys, if it moves
int choose_level(const LevelSettings& settings, const PosedCage& cage);

/// Returns the level of edges that are as long as the steps of the floats in which the tree keeps boxes where the cage is
/// (LevelSettings::origin). Boxes of finer tiles would be the same but for rounding, and a ray would meet many that it does
/// not pass. A cage that moves has the least level of all segments of its motion, each by its end that is farther away.
/// cage   as in choose_level()
int level_of_boxes(const LevelSettings& settings, const PosedCage& cage) noexcept;

}  // namespace occam::lod
