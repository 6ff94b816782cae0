// What all workers of a frame read: it is made from the inputs of the frame before the first tile.
#pragma once

#include "accel/frame.h"
#include "render/frame.h"
#include "render/hole_filter.h"
#include "render/integrator.h"
#include "scenegraph/frame_scale.h"
#include "shade/material_values.h"

namespace occam::render {

/// Returns the rays of a camera through the pixels of a picture with these settings, in the unit of length of the frame.
/// Their footprints are those of Settings::lod_camera, if it is given.
CameraRays camera_of(const Settings& settings, const FrameScale& scale, const Camera& camera);

/// Borrows the inputs. Its parts refer to each other, so it stays in place.
struct FrameSetup {
    explicit FrameSetup(const FrameInputs& inputs);
    FrameSetup(const FrameSetup&) = delete;
    FrameSetup& operator=(const FrameSetup&) = delete;

    FrameScale scale;
    CameraRays camera;
    lod::LevelSettings levels;
    PixelFilter filter;
    Sampler sampler;
    shade::FrameLights lights;
    PassBudget passes;
    FrameContext context;
    shade::PhaseOne phase_one;
    HoleFilter holes;
    accel::Frame frame;
};

}  // namespace occam::render
