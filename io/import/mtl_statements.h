// Preparation of an MTL library for tinyobjloader, which swallows words and cannot tell what a file leaves out.
#pragma once

#include <string>
#include <string_view>

#include "io/import/report.h"

namespace occam::import {

/// The value of a colour (in all parts), index of refraction, roughness or metalness that a material does not say.
inline constexpr float kNotGiven = -1;

/// Returns the library with the same materials in a form that tinyobjloader reads as the format means it: each material
/// begins with values of kNotGiven, colours have three parts, options of images have all their numbers, and values that
/// cannot be read are left out, with a warning (a Kd becomes white).
/// name   the name of the library in warnings
std::string prepare_mtl(std::string_view text, const std::string& name, Report& report);

}  // namespace occam::import
