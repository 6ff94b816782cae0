// Rules of glTF that take more than one property to judge. The document has passed check_schema().
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "io/import/report.h"

namespace occam::import {

/// Buffers, views and accessors: what does not fit throws Error, what is only badly aligned or hinted is a warning.
void check_data_rules(const nlohmann::json& root, Report& report);

/// Nodes, scenes, skins, cameras, meshes, animations: a tree that is none throws Error, the rest is a warning.
void check_scene_rules(const nlohmann::json& root, Report& report);

}  // namespace occam::import
