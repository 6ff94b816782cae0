// The memory budget of a frame is divided evenly among the workers, each with queues of rays and a tracer's arena.
//
// The budget is for what is built anew in every frame. The scene, its topology tables, textures
// (Resources::texture_bytes) and the picture itself are not part of it.
#pragma once

#include "render/settings.h"
#include "scenegraph/scene.h"

namespace occam::render {

struct MemoryPlan {
    std::size_t floor_bytes = 0;   ///< the smallest budget that suffices for this scene and number of threads
    int batch_rays = 0;            ///< camera rays that a worker starts together
    std::size_t shadow_batch = 0;  ///< shadow rays that may wait before they are traced
    std::size_t queue_bytes = 0;   ///< part of each worker that holds queues of rays
    std::size_t tracer_bytes = 0;  ///< part of each worker that its tracer gets, which is the rest
};

/// Divides the budget. Throws Error naming the floor if the budget is below it. The picture does not depend on the plan.
/// resources   resolved
MemoryPlan plan_memory(const Scene& scene, const Resources& resources);

}  // namespace occam::render
