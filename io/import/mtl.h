// The importer of Wavefront MTL with the PBR extension into the material model.
#pragma once

#include <map>
#include <optional>

#include "io/import/report.h"

namespace occam::import {

/// libraries   the rest of each mtllib line: one name with spaces in it, or several names
/// Returns the materials by name; none if not even one library could be read. A library that is missing or outside the
/// scene's folder is a warning.
std::optional<std::map<std::string, MaterialId>> read_mtl(const std::vector<std::string>& libraries, Scene& scene,
                                                          Report& report);

}  // namespace occam::import
