// Holds the private state of accel::Frame, for the files of this room.
#pragma once

#include "accel/frame.h"

namespace occam::accel {

/// A margin as a fraction of a cage's radius: the hull of control points holds the surface except for the rounding of
/// vertices, which are sums of up to hundreds of control points.
inline constexpr double kVertexRounding = 0x1p-14;
/// The same margin for any cages inside a box: a cage's ball has less than twice the radius of a box around the cage.
inline double vertex_rounding(const Box3d& box) noexcept { return 2 * box.radius() * kVertexRounding; }

struct FrameState {
    const Scene* scene = nullptr;
    lod::TopologyCache* topologies = nullptr;
    lod::LevelSettings levels;
    FrameScale scale;
    const TextureStore* textures = nullptr;  ///< textures of displacements
    lod::VertexShading shading;
    TreeKind tree = TreeKind::Kd;  ///< never Auto
    bool refuses_endless = true;
    Vec3d anchor{0};  ///< origin of the tree's frame: the point of the scene's bounds that is nearest to the eye
    Box3f bounds;     ///< bounds of the scene, in the tree's frame
    /// A box that holds all surfaces with several levels, in the tree's frame. A ray's pairs of levels are those that it
    /// sees within this box: their number is limited (RayLevels::kMostOfRay), and meshes beyond the box need none.
    Box3f diced_bounds;
    /// Rays see several levels of detail: levels are chosen by each ray, and not all cages are meshes of triangles.
    bool has_levels = true;
    float radius = 0;  ///< radius of a ball about the anchor that holds the scene
    int segments = 0;  ///< of the scene's shutter; 0: nothing moves

    /// Returns whether the tree holds what moves wherever it passes, so that rays meet it there at any time.
    bool holds_swept() const noexcept { return tree == TreeKind::Kd && segments > 0; }
};

struct Frame::State : FrameState {};

}  // namespace occam::accel
