// How sharply the surface of a cage bends, which says how much edges of some length cut off from it.
#pragma once

#include "scenegraph/cage.h"

namespace occam::lod {

/// Returns an estimate of the least radius of curvature of a subdivision cage's limit surface, in the cage's own length,
/// from how far the normals of its control points turn along its edges; infinity where it is flat. Displacement does not
/// count.
double least_radius_of_curvature(const Cage& cage);

}  // namespace occam::lod
