// Reading of the skins and clips of a glTF into the data model; they are evaluated elsewhere.
#pragma once

#include <unordered_map>
#include <vector>

#include "io/import/gltf_accessor.h"
#include "io/import/gltf_skin_paths.h"

namespace occam::import {

/// nodes   by index in the file; none for a node that is not in the scene
/// paths   from which the nodes above the joints are taken
/// Returns skins by index; none for a skin that cannot be used (a warning).
std::vector<SkinId> add_skins(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes,
                              Scene& scene, SkinPaths& paths, Report& report);

/// The nodes that show the mesh of a node, where EXT_mesh_gpu_instancing has one for each instance.
using InstancesOf = std::unordered_map<NodeId, std::vector<NodeId>>;

/// Adds the clips. Animated weights of a node with instances move all of these.
void add_clips(const tinygltf::Model& model, AccessorReader& accessors, const std::vector<NodeId>& nodes,
               const InstancesOf& instances, Scene& scene, Report& report);

}  // namespace occam::import
