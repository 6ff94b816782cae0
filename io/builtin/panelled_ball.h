// A ball of panels with five and six corners, as footballs are sewn.
#pragma once

#include <string>

#include "scenegraph/cage.h"

namespace occam::builtin {

/// Twelve pentagons and twenty hexagons (the truncated icosahedron) about the origin, each a puffed panel: an n-gon inside a
/// ring of quads. Seams lie at `radius`, are creased with `sharpness`, and panels rise above them by `puff` of it. Material
/// slot 0: hexagons, 1: pentagons.
Cage panelled_ball(std::string name, float radius, float puff, float sharpness);

}  // namespace occam::builtin
