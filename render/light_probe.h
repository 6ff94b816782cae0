// Finds out whether the emissive surfaces of a scene light what its camera sees.
//
// A scene without lights and environment is lit by its emissive surfaces, or else by the default light. Their power alone
// does not tell which: a glowing floor may leave everything that stands on it black. So a small picture is made with the
// emissive surfaces alone, and the default light stays away only if enough of what is seen in it is lit.
#pragma once

#include "render/frame.h"
#include "scenegraph/frame_scale.h"
#include "shade/frame_lights.h"

namespace occam::render {

/// Gathers the lights of the frame: those of the scene, and the default light where Settings::sky and the scene ask for it.
/// The choice depends on the scene, the camera and the settings alone. It renders the small picture if it needs to.
/// scale   the unit of length of the frame, in which the lights are
shade::FrameLights lights_of(const FrameInputs& inputs, const FrameScale& scale);

}  // namespace occam::render
