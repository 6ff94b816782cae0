// Reading of many copies of one mesh under a node (EXT_mesh_gpu_instancing).
#pragma once

#include "io/import/gltf_accessor.h"
#include "scenegraph/animation.h"

namespace occam::import {

/// The limit is more instances than any file of ours has, and fewer than would fill the memory with their nodes.
inline constexpr std::size_t kMaxInstances = std::size_t(1) << 20;

/// Returns the places of a node's instances in the node's axes, empty if it has none. Throws Error if the attributes do not
/// fit together, or if there are more than `left` instances.
std::vector<Trs> instance_places(const tinygltf::Node& node, AccessorReader& accessors, std::size_t left,
                                 const Report& report, const std::string& where);

}  // namespace occam::import
