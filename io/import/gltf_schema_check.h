// The check of a JSON document against the table of gltf_schema.h.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "io/import/report.h"

namespace occam::import {

/// Checks the types, required properties, ranges and indices of everything in `root`. Throws Error where the document cannot
/// be used; unknown properties, empty arrays and misplaced extensions are warnings.
void check_schema(const nlohmann::json& root, Report& report);

}  // namespace occam::import
