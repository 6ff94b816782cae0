// A ball of panels with five and six corners, sewn as footballs are.
#pragma once

#include <string>

#include "scenegraph/cage.h"

namespace occam::builtin {

/// Returns twelve pentagons and twenty hexagons (the truncated icosahedron) about the origin. Each is a puffed panel: an
/// n-gon inside a ring of quads. The seams lie at `radius` and are creased with `sharpness`; the panels rise above them by
/// the fraction `puff` of the radius. Material slot 0 holds the hexagons, slot 1 the pentagons.
Cage panelled_ball(std::string name, float radius, float puff, float sharpness);

}  // namespace occam::builtin
