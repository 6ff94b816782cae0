// How little memory a tracer can do with.
#pragma once

#include "accel/ray_lanes.h"
#include "scenegraph/scene.h"

namespace occam::accel {

/// What one ray may need of a tracer's arena: a way down through the scene's widest node and largest cage, and some igrids.
/// A ray that passes through more is granted it all the same.
std::size_t memory_floor(const Scene& scene);

/// What a tracer keeps for each ray of a batch, beside its arena.
inline constexpr std::size_t kBytesOfABatchedRay = sizeof(Ray) + sizeof(std::uint16_t) + sizeof(std::uint32_t);

}  // namespace occam::accel
