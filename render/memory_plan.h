// How the memory budget of a frame is shared out: evenly among the workers, each with queues of rays and a tracer's arena.
//
// The budget is for what is built anew each frame. Beside it stand the scene, its topology tables, textures
// (Resources::texture_bytes) and the picture itself.
#pragma once

#include "render/settings.h"
#include "scenegraph/scene.h"

namespace occam::render {

struct MemoryPlan {
    std::size_t floor_bytes = 0;   ///< the least budget that this scene and so many threads can do with
    int batch_rays = 0;            ///< camera rays that a worker starts together
    std::size_t shadow_batch = 0;  ///< shadow rays that may wait before they are traced
    std::size_t queue_bytes = 0;   ///< of a worker: for as many rays on their way
    std::size_t tracer_bytes = 0;  ///< of a worker: the rest
};

/// resources   resolved
/// Throws Error naming the floor if the budget is below it. The picture does not depend on the plan.
MemoryPlan plan_memory(const Scene& scene, const Resources& resources);

}  // namespace occam::render
