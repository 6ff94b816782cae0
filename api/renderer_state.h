// The state that a renderer keeps from frame to frame; it is private to api/.
#pragma once

#include <algorithm>
#include <atomic>
#include <mutex>
#include <vector>

#include "io/texture/texture_store.h"
#include "lod/topology_cache.h"
#include "occam/occam.h"
#include "shade/frame_lights.h"

namespace occam {

/// Holds topology tables that several callers may use.
class SharedTopologies {
public:
    lod::TopologyCache cache;

private:
    friend class TopologyUse;
    std::mutex mutex_;
    std::vector<const Scene*> scenes_;  ///< one for each user
};

/// Borrows the tables for a frame, or for as long as a query may be asked. Tables of cages that neither the scene nor that
/// of another user has are forgotten first. The scene is locked meanwhile.
class TopologyUse {
public:
    TopologyUse(std::shared_ptr<SharedTopologies> tables, const Scene& scene) : tables_(std::move(tables)), scene_(&scene)
    {
        const std::lock_guard guard(tables_->mutex_);
        tables_->scenes_.push_back(scene_);
        tables_->cache.prune(tables_->scenes_);
    }
    ~TopologyUse()
    {
        const std::lock_guard guard(tables_->mutex_);
        std::vector<const Scene*>& scenes = tables_->scenes_;
        scenes.erase(std::find(scenes.begin(), scenes.end(), scene_));
    }
    TopologyUse(const TopologyUse&) = delete;
    TopologyUse& operator=(const TopologyUse&) = delete;

    lod::TopologyCache& cache() const noexcept { return tables_->cache; }

private:
    std::shared_ptr<SharedTopologies> tables_;
    const Scene* scene_;
};

struct Renderer::State {
    explicit State(const Resources& wished) : resources(wished.resolved()), textures(resources.texture_bytes) {}

    Resources resources;
    std::shared_ptr<SharedTopologies> topologies = std::make_shared<SharedTopologies>();
    TextureStore textures;
    shade::KeptFrameLights lights;
    std::atomic<bool> busy = false;
    std::mutex stats_mutex;  // guards the writing of `stats`
    FrameStats stats;
};

}  // namespace occam
