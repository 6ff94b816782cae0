// One frame's view of a scene, shared by all workers: what is constant from the first tile to the last.
#pragma once

#include <memory>

#include "io/texture/texture_store.h"
#include "lod/footprint.h"
#include "lod/topology_cache.h"
#include "lod/vertex_shader.h"
#include "scenegraph/scene.h"

namespace occam::accel {

/// Read only while tracers live. Borrows scene and topologies.
class Frame {
public:
    /// scene    refitted; not edited while this lives
    /// eye      of the camera whose footprints choose the level of each cage instance
    /// textures prepared; null: nothing is displaced
    /// shading  phase one at the vertices of grids, for SurfaceHit::phase_one; its shader is borrowed
    Frame(const Scene& scene, lod::TopologyCache& topologies, const lod::LevelSettings& levels,
          const TextureStore* textures = nullptr, const lod::VertexShading& shading = {});
    ~Frame();

    struct State;
    const State& state() const noexcept { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace occam::accel
