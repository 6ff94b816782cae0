// Walks a JSON document by the table of gltf_schema.h.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "io/import/report.h"

namespace occam::import {

/// Types, required properties, ranges and indices of everything in `root`. Throws Error where nothing can be made of it;
/// unknown properties, empty arrays and misplaced extensions are warnings.
void check_schema(const nlohmann::json& root, Report& report);

}  // namespace occam::import
