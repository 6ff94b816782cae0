// What accel::Frame holds: the inside of that type, for the files of this room.
#pragma once

#include "accel/frame.h"

namespace occam::accel {

/// Of a cage's radius: the hull of control points holds the surface but for the rounding of vertices, sums of up to hundreds
/// of them.
inline constexpr double kVertexRounding = 0x1p-14;
/// The same of whatever cages a box holds: a cage's ball has less than twice the radius of a box around the cage.
inline double vertex_rounding(const Box3d& box) noexcept { return 2 * box.radius() * kVertexRounding; }

struct FrameState {
    const Scene* scene = nullptr;
    lod::TopologyCache* topologies = nullptr;
    lod::LevelSettings levels;
    const TextureStore* textures = nullptr;  ///< of displacement
    lod::VertexShading shading;
    Vec3d anchor{0};   ///< of the tree's frame: a lattice point near the scene's middle
    Box3f bounds;      ///< of the scene, tree's frame
    float radius = 0;  ///< of a ball about the anchor that holds the scene
};

struct Frame::State : FrameState {};

}  // namespace occam::accel
