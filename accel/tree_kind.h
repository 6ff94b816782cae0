// Names the trees that may hold a frame's items.
#pragma once

#include <cstdint>

namespace occam::accel {

/// Hits have the same bits in either tree.
enum class TreeKind : std::uint8_t {
    Auto,  ///< boxes where something moves while the shutter is open or all is meshes, else the kd-tree
    Kd,    ///< accel/kd_tree.h
    Bvh    ///< accel/bvh.h
};

}  // namespace occam::accel
