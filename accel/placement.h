// Tells where the nodes of a scene are, and when they are seen, during a frame's shutter.
#pragma once

#include <functional>
#include <span>

#include "scenegraph/scene.h"

namespace occam::accel {

/// Returns a mask whose bit k tells whether a node is visible below its parent in segment k of the scene's shutter. All bits
/// are set for a node that is always visible.
/// segments   of the shutter; 0: it has none
std::uint32_t visible_in(const Node& node, int segments) noexcept;

/// Returns whether the node's own transform changes in the shutter.
bool moves_in_parent(const Node& node) noexcept;

/// Returns a box that holds all that is diced (Contents::Subdivided) and is visible at some time, in world axes. Where the
/// scene is large it may be larger than that. The scene must be refitted.
Box3d bounds_of_diced(const Scene& scene);

/// Calls visit(node, world_from_node) for every placement that is visible at some time. world_from_node is given at each key
/// of the shutter, or once if no transform on the way to the node changes. Throws Error if there are more than kMostListed.
/// kinds   only nodes of which the subtree holds one of these are visited; 0: all are. The scene must be refitted.
void for_each_placement(const Scene& scene, Contents::Kinds kinds,
                        const std::function<void(const Node&, std::span<const Mat4d>)>& visit);

}  // namespace occam::accel
