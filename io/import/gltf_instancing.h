// Reading of many copies of one mesh under a node (EXT_mesh_gpu_instancing).
#pragma once

#include "base/box.h"
#include "io/import/gltf_accessor.h"
#include "scenegraph/animation.h"

namespace occam::import {

/// The limit is more instances than any file of ours has, and fewer than would fill the memory with their nodes.
inline constexpr std::size_t kMaxInstances = std::size_t(1) << 20;

/// Returns the places of a node's instances in the node's axes, empty if it has none. Throws Error if the attributes do not
/// fit together, or if there are more than `left` instances.
std::vector<Trs> instance_places(const tinygltf::Node& node, AccessorReader& accessors, std::size_t left, Report& report,
                                 const std::string& where);

/// The largest number of instances of a node whose boxes a line through all of them may meet on average.
inline constexpr double kMostOverlap = 16384;

/// Removes all places but the first of those that are equal, since their instances cannot be told apart, and returns how
/// many it has removed.
std::size_t remove_equal(std::vector<Trs>& places);

/// Returns the number of instances whose boxes a line meets that meets any of them, on average over all lines: the areas of
/// the boxes over the area of the box that holds them all.
/// shape   the box of the mesh, in its own axes
double overlap_of(const std::vector<Trs>& places, const Box3d& shape);

}  // namespace occam::import
