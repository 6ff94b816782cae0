// Rules of glTF that involve more than one property. The document has passed check_schema().
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "io/import/report.h"

namespace occam::import {

/// Checks buffers, views and accessors: what does not fit throws Error; wrong alignment or a wrong hint is a warning.
void check_data_rules(const nlohmann::json& root, Report& report);

/// Checks nodes, scenes, skins, cameras, meshes and animations: a node graph that is not a tree throws Error, the rest is a
/// warning.
void check_scene_rules(const nlohmann::json& root, Report& report);

}  // namespace occam::import
