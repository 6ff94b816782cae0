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

/// The limit to overlap_of(): a ray has to look at all instances whose boxes it passes.
inline constexpr double kMostOverlap = 16384;

/// Removes all places but the first of those that are equal, since their instances cannot be told apart, and returns how
/// many it has removed.
std::size_t remove_equal(std::vector<Trs>& places);

/// Places the shape many times, and returns through how many of the boxes of these instances a line passes on average. It
/// counts all lines through the box that holds them all. The average is the sum of the areas of the boxes, divided by the
/// area of that one.
/// shape   the box of the mesh, in its own axes
double overlap_of(const std::vector<Trs>& places, const Box3d& shape);

}  // namespace occam::import
