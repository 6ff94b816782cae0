// One frame: tiles are handed to workers, each with a tracer and an integrator of its own.
//
// Borrows   everything in FrameInputs until render_frame() returns. The caller has refitted and locked the scene.
// Memory    see memory_plan.h; beside that, the film takes a few floats per pixel.
// Threads   one call starts `threads` workers; the picture does not depend on their number.
#pragma once

#include <chrono>

#include "io/texture/texture_store.h"
#include "lod/topology_cache.h"
#include "render/frame_control.h"
#include "render/image.h"
#include "render/memory_plan.h"
#include "render/settings.h"
#include "render/stats.h"
#include "scenegraph/scene.h"
#include "shade/frame_lights.h"

namespace occam::render {

struct FrameInputs {
    const Scene& scene;
    Box3d scene_bounds;
    const Camera& camera;
    const Settings& settings;    ///< checked
    const Resources& resources;  ///< resolved
    const MemoryPlan& memory;
    lod::TopologyCache& topologies;
    const TextureStore& textures;
    shade::KeptFrameLights& lights;  ///< of the frame before; becomes those of this one
    std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
    bool keeps_checkpoint = true;   ///< false: nobody will ask for FrameResult::checkpoint
    std::string_view checkpoint{};  ///< belongs to the same picture; if empty, the frame starts at its first sample
};

struct FrameResult {
    Image image;
    std::string checkpoint;  ///< lets an unfinished frame that was made in rounds continue; else, or if not kept, empty
    float clamp = 0;         ///< the limit of scattered light, which Settings::clamp_as_shown may have changed
};

/// Renders the frame and adds its cost to `stats`. It ends early where a texture proves unreadable, and then holds nothing
/// that was made since. Throws Error for a checkpoint of another picture.
FrameResult render_frame(const FrameInputs& inputs, FrameControl& control, FrameStats& stats);

}  // namespace occam::render
