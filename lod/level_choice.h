// Which level a cage instance is seen at, when all rays of a frame share one.
#pragma once

#include "lod/footprint.h"
#include "lod/posed_cage.h"

namespace occam::lod {

/// Largest level with d_l <= wanted edge where the camera's footprint on the cage is smallest: at the nearest cluster in
/// view (or the nearest of all, if none is). Next to the eye a cluster counts as an eighth of its radius away: nothing is
/// infinitely fine. Cost: the clusters nearer than the nearest, O(log n) as a rule.
int choose_level(const LevelSettings& settings, const PosedCage& cage);

}  // namespace occam::lod
