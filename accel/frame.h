// Holds one frame's view of a scene, shared by all workers: the data that is constant from the first tile to the last.
#pragma once

#include <memory>

#include "accel/tree_kind.h"
#include "io/texture/texture_store.h"
#include "lod/footprint.h"
#include "lod/topology_cache.h"
#include "lod/vertex_shader.h"
#include "scenegraph/frame_scale.h"
#include "scenegraph/scene.h"

namespace occam::accel {

/// Says what a frame of an application has beyond a scene and its levels; what is left out is not needed.
struct FrameOptions {
    const TextureStore* textures = nullptr;  ///< prepared; if null, nothing is displaced
    lod::VertexShading shading{};            ///< phase one at the vertices of grids, for SurfaceHit::phase_one; borrowed
    FrameScale scale{};                      ///< the unit of the frame; its levels are in it
    TreeKind tree = TreeKind::Auto;          ///< holds the items; it has no influence on what a ray hits
    /// Whether a frame that would not end is refused (accel/build_effort.h). Where an application asks about few rays at a
    /// time, it can stop between them, and each of them ends.
    bool refuses_endless = true;
};

/// It is only read while tracers live. It borrows the scene and the topologies. Rays, hits and levels of its tracers are in
/// frame lengths.
class Frame {
public:
    /// scene     must have been refitted, and must not be edited while this object lives.
    /// levels    belong to the camera whose footprints choose levels.
    Frame(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
          const FrameOptions& options = {});
    ~Frame();

    /// Returns the tree that holds the items of this frame, which is never Auto.
    TreeKind tree() const noexcept;

    struct State;
    const State& state() const noexcept { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace occam::accel
