// Rules of glTF that involve more than one property. The document has passed check_schema().
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <set>

#include "io/import/report.h"

namespace occam::import {

/// Checks buffers, views and accessors: what does not fit throws Error; wrong alignment or a wrong hint is a warning.
void check_data_rules(const nlohmann::json& root, Report& report);

/// Checks nodes, scenes, skins, cameras, meshes and animations: a node graph that is not a tree throws Error, the rest is a
/// warning.
void check_scene_rules(const nlohmann::json& root, Report& report);

/// Returns the numbers of the sets of texture coordinates (TEXCOORD_n) that the textures of a material use which are read.
std::set<std::int64_t> coordinate_sets(const nlohmann::json& material);

}  // namespace occam::import
