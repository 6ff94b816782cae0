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

}  // namespace occam::lod
