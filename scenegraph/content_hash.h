// A hash of what a scene shows, which tells whether a stopped frame may continue with it.
//
// It is the same in every process and whatever was added and removed before: handles count by the order in which a walk from
// the root meets them. Nodes that are visible count with their names, places and order, also those that hold nothing; what
// no node shows does not. Of an image in a file it knows the path, and of a cage on demand its name, bounds and materials.
//
// Time     linear in the bytes of what the scene shows.
// Threads  reads the scene only.
#pragma once

#include <cstdint>

#include "scenegraph/scene.h"

namespace occam {

/// Returns the hash. The scene must be refitted.
std::uint64_t content_hash(const Scene& scene);
/// Returns a hash of the same content and of the slots of its nodes, which the layer "id" and the view of faces show. It
/// depends on what was added and removed before.
std::uint64_t content_and_slots_hash(const Scene& scene);

}  // namespace occam
