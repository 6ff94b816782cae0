// The state that a renderer keeps from frame to frame; it is private to api/.
#pragma once

#include <atomic>
#include <mutex>

#include "io/texture/texture_store.h"
#include "lod/topology_cache.h"
#include "occam/occam.h"
#include "shade/placed_lights.h"

namespace occam {

/// Holds topology tables that several callers may use. They are pruned only while no query uses them, because a query may
/// ask about a scene other than the one to be rendered.
class SharedTopologies {
public:
    lod::TopologyCache cache;

    void prune_if_unused(const Scene& scene)
    {
        const std::lock_guard guard(mutex_);
        if (users_ == 0) cache.prune(scene);
    }
    void add_user()
    {
        const std::lock_guard guard(mutex_);
        ++users_;
    }
    void remove_user() noexcept
    {
        const std::lock_guard guard(mutex_);
        --users_;
    }

private:
    std::mutex mutex_;
    int users_ = 0;
};

struct Renderer::State {
    explicit State(const Resources& wished) : resources(wished.resolved()), textures(resources.texture_bytes) {}

    Resources resources;
    std::shared_ptr<SharedTopologies> topologies = std::make_shared<SharedTopologies>();
    TextureStore textures;
    shade::KeptLights lights;
    std::atomic<bool> busy = false;
    FrameStats stats;
};

}  // namespace occam
