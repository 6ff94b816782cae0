// What all workers of a frame read.
#pragma once

#include <cstddef>

#include "io/texture/texture_store.h"
#include "render/camera_rays.h"
#include "render/filter.h"
#include "render/pass_budget.h"
#include "render/sampler.h"
#include "render/settings.h"
#include "scenegraph/frame_scale.h"
#include "shade/frame_lights.h"

namespace occam {

class Scene;

}  // namespace occam

namespace occam::render {

class PathLog;

/// Holds what all workers read.
struct FrameContext {
    const Settings& settings;
    const CameraRays& camera;
    const Sampler& sampler;
    const PixelFilter& filter;
    const shade::FrameLights& lights;
    const TextureStore& textures;
    PassBudget& passes;
    bool may_pass = false;                ///< some material of the scene transmits light straight on
    bool moves = false;                   ///< something moves while the shutter is open: samples have moments
    bool may_start_in_body = false;       ///< some body of the scene absorbs light, and camera rays may start in it
    float depth_near = 0, depth_far = 1;  ///< camera z of the scene, for View::Depth
    const Scene* scene = nullptr;         ///< has the names that Cryptomatte needs
    FrameScale scale{};                   ///< all other lengths of the frame are in its unit
    static constexpr std::size_t kShadowBatch = 16384;
    std::size_t shadow_batch = kShadowBatch;  ///< shadow rays that may wait before they are traced
    float clamp = settings.clamp;             ///< Settings::clamp, or what it is for the exposure that was measured
    PathLog* log = nullptr;                   ///< if not null, it is told what happens to the path of the only sample
};

}  // namespace occam::render
