// Chooses the level at which a placement is seen, if all rays of a frame share one.
#pragma once

#include "lod/footprint.h"
#include "lod/posed_cage.h"

namespace occam::lod {

/// Returns the largest level with d_l <= target edge length where the camera's footprint on the cage is smallest: at the
/// nearest cluster in view (or the nearest of all, if none is in view). Next to the eye a cluster counts as an eighth of its
/// radius away, so that nothing is infinitely fine. It visits the clusters nearer than the nearest, usually O(log n).
int choose_level(const LevelSettings& settings, const PosedCage& cage);

}  // namespace occam::lod
