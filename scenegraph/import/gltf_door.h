// The door of glTF: what a file must hold before anything reads it.
//
// glTF 2.0 specification (Khronos, 2021) and the schemas of the extensions that we know.
#pragma once

#include <set>
#include <string_view>

#include "scenegraph/import/report.h"

namespace occam::import {

/// The JSON of a GLB container; checks header, chunk order and lengths (sec. 4).
std::string_view glb_json(std::string_view bytes, const Report& report);

/// Checks JSON against the schema: types, required properties, ranges, and that every index names something.
/// What a renderer can do without (an unknown property, a wrong hint) is a warning; the rest throws Error.
/// Returns the URIs of buffers that are files.
std::set<std::string> check_gltf(std::string_view json_text, bool is_glb, Report& report);

}  // namespace occam::import
