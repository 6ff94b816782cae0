// Colours as polygon files give them: of vertices or of faces, in integers or in numbers from 0 to 1.
#pragma once

#include "io/import/polygons.h"

namespace occam::import {

/// Returns the linear colour of an sRGB colour; alpha stays as it is.
Vec4f linear_color(Vec4f srgb);

/// Makes colours that are not between 0 and 1 the nearest ones that are, with a warning.
void clamp_colors(std::vector<Vec4f>& colors, Report& report, const std::string& where = {});

/// Gives each face its colour, which all of its corners get; white where `colors` ends early. Vertices that have colours
/// keep theirs, with a warning.
void set_face_colors(Polygons& polygons, std::vector<Vec4f> colors, Report& report);

}  // namespace occam::import
