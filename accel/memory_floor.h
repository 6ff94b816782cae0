// Computes the least memory that a tracer can work with.
#pragma once

#include "accel/ray_lanes.h"
#include "scenegraph/scene.h"

namespace occam::accel {

/// Returns the bytes that one ray may need in a tracer's arena: the longest path down through the scene, its widest
/// node and largest cage, and some igrids. A ray that needs more is granted it all the same, up to kMostBytesOfARay.
std::size_t memory_floor(const Scene& scene);
inline constexpr std::size_t kMostBytesOfARay = std::size_t(3) << 29;

/// Returns the bytes that a tracer keeps for each ray of a batch, beside its arena.
inline constexpr std::size_t kBytesOfABatchedRay = sizeof(Ray) + sizeof(std::uint16_t) + sizeof(std::uint32_t);

}  // namespace occam::accel
