// Reading of the skins and clips of a glTF into the data model; they are evaluated elsewhere.
#pragma once

#include "io/import/gltf_accessor.h"
#include "io/import/gltf_skin_paths.h"

namespace occam::import {

/// nodes   by index in the file; none for a node that is not in the scene
/// paths   from which the nodes above the joints are taken
/// Returns skins by index; none for a skin that cannot be used (a warning).
std::vector<SkinId> add_skins(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes,
                              Scene& scene, SkinPaths& paths, Report& report);
void add_clips(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes, Scene& scene,
               Report& report);

}  // namespace occam::import
