// Which nodes are hidden from rays of some kind by themselves or by a node above them.
#pragma once

#include <cstdint>
#include <unordered_set>

#include "scenegraph/scene.h"

namespace occam {

/// Returns the nodes that themselves or below hold one of these kinds of Contents, and that rays of one of the kinds in
/// `rays` do not see in one of their placements.
std::unordered_set<NodeId> nodes_hidden_from(const Scene& scene, std::uint8_t rays, Contents::Kinds kinds);

}  // namespace occam
