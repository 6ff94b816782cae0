#include "render/memory_plan.h"

#include <algorithm>

#include "accel/memory_floor.h"
#include "base/error_without_file.h"
#include "render/film.h"
#include "render/integrator.h"
#include "render/path.h"
#include "render/tiles.h"

namespace occam::render {
namespace {

// This is enough for a tracer's packets and streams, and few enough that a cancelled frame stops soon.
constexpr int kMostRays = 4096;
constexpr int kLeastRays = kTileSide * kTileSide;  // one sample of each pixel of a tile
constexpr std::size_t kShadowRays = FrameContext::kShadowBatch /
                                    kMostRays;  // shadow rays that may wait, for each ray of a batch

// A ray that is followed takes memory for itself and its successor. Surfaces that split rays in two may need more.
constexpr std::size_t kBytesOfARay = 2 * (sizeof(Path) + sizeof(accel::Ray)) + sizeof(accel::SurfaceHit) +
                                     sizeof(SampleResult) + 4 * sizeof(int) + sizeof(Vec3f) + sizeof(float) +
                                     accel::kBytesOfABatchedRay;
constexpr std::size_t kBytesOfAShadowRay = sizeof(accel::Ray) + 5 * sizeof(Vec4f) + accel::kBytesOfABatchedRay;
constexpr std::size_t queue_bytes(int rays) { return std::size_t(rays) * (kBytesOfARay + kShadowRays * kBytesOfAShadowRay); }

// Both are in the units of --memory. What is needed is rounded up and what is given is rounded down, so that an error never
// shows two equal numbers.
std::string needed(std::size_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + "M"; }
std::string given(std::size_t bytes)
{
    if (bytes < 1 << 10) return std::to_string(bytes) + (bytes == 1 ? " byte" : " bytes");
    return bytes < (1 << 20) ? std::to_string(bytes >> 10) + "K" : std::to_string(bytes >> 20) + "M";
}

}  // namespace

MemoryPlan plan_memory(const Scene& scene, const Resources& resources)
{
    const auto threads = static_cast<std::size_t>(resources.threads);
    const std::size_t of_a_worker = resources.memory_bytes / threads;
    MemoryPlan plan;
    const std::size_t floor_of_tracer = accel::memory_floor(scene);
    plan.floor_bytes = threads * (queue_bytes(kLeastRays) + floor_of_tracer);
    if (resources.memory_bytes < plan.floor_bytes)
        throw error_without_file("this scene needs a memory budget of " + needed(plan.floor_bytes) + " or more with " +
                                     std::to_string(threads) + (threads == 1 ? " thread" : " threads"),
                                 given(resources.memory_bytes) + " given");
    // Queues are short beside the arena, and leave the tracer at least what it needs.
    const std::size_t most_of_queues = std::min(of_a_worker / 8, of_a_worker - floor_of_tracer);
    plan.batch_rays = kMostRays;
    while (plan.batch_rays > kLeastRays && queue_bytes(plan.batch_rays) > most_of_queues) plan.batch_rays /= 2;
    plan.shadow_batch = kShadowRays * static_cast<std::size_t>(plan.batch_rays);
    plan.queue_bytes = queue_bytes(plan.batch_rays);
    plan.tracer_bytes = of_a_worker - plan.queue_bytes;
    return plan;
}

}  // namespace occam::render
