// A sketch of the frame: a small picture with few samples, which tells how bright the frame is shown before it is made.
//
// It is traced in the frame's own trees, so what it builds serves the frame, too. A picture of few pixels is nearly all
// building.
#pragma once

#include "render/crew.h"
#include "render/frame_setup.h"

namespace occam::render {

/// Changes the limit of scattered light in the context to that for the exposure of the picture, if
/// Settings::clamp_as_shown asks for it. The exposure is automatic_exposure() of a sketch of the whole frame, which has at
/// most 96 columns, at most four samples a pixel and no limit. It does not depend on the crop, nor on the tracers. The rays
/// and their time are added to `stats`. Debug views and ambient occlusion have no limit, so nothing is made for them.
void set_limit_as_shown(const FrameInputs& in, FrameSetup& setup, FrameTracers& tracers, FrameControl& control,
                        FrameStats& stats);

}  // namespace occam::render
