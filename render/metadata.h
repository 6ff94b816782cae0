// Sets attributes that say how a picture was made, under the names of OpenEXR's standard attributes.
#pragma once

#include "render/image.h"
#include "render/settings.h"
#include "render/stats.h"
#include "scenegraph/camera.h"

namespace occam::render {

/// Sets Image::is_light, worldToCamera (camera axes: right, up, forward), worldToNDC (the frame is 0 to 1 from the upper
/// left), chromaticities (Rec.709 and D65), comments, capDate and utcOffset.
void describe(Image& image, const Camera& camera, const Settings& settings, const FrameStats& stats);

}  // namespace occam::render
