// What accel::Frame holds: the inside of that type, for the files of this room.
#pragma once

#include "accel/frame.h"

namespace occam::accel {

struct FrameState {
    const Scene* scene = nullptr;
    lod::TopologyCache* topologies = nullptr;
    lod::LevelSettings levels;
    const TextureStore* textures = nullptr;  ///< of displacement
    lod::VertexShading shading;
    Vec3d anchor{0};  ///< of the tree's frame: a lattice point near the scene's middle
    Box3f bounds;     ///< of the scene, tree's frame
    float radius = 0; ///< of a ball about the anchor that holds the scene
};

struct Frame::State : FrameState {};

}  // namespace occam::accel
