// Many copies of one mesh under a node (EXT_mesh_gpu_instancing).
#pragma once

#include "io/import/gltf_accessor.h"
#include "scenegraph/animation.h"

namespace occam::import {

/// More instances than any file of ours has, and less than memory for their nodes.
inline constexpr std::size_t kMaxInstances = std::size_t(1) << 20;

/// Where the instances of a node lie in its axes; empty if the node has none. Throws Error if the attributes do not fit
/// together, or if there are more than `left` instances.
std::vector<Trs> instance_places(const tinygltf::Node& node, AccessorReader& accessors, std::size_t left,
                                 const Report& report, const std::string& where);

}  // namespace occam::import
