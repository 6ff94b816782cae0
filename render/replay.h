// Traces one sample of a picture again, and writes what each of its rays does and how each hit is shaded.
#pragma once

#include <iosfwd>

#include "render/film.h"
#include "render/frame.h"
#include "render/integrator.h"

namespace occam::render {

/// Returns what the sample contributes to the picture, with the same bits. Throws Error for a pixel outside of the picture,
/// and for a sample that a pixel does not have.
SampleResult replay_sample(const FrameInputs& inputs, const CameraSample& sample, std::ostream& out);

}  // namespace occam::render
