// Sets attributes that say how a picture was made, under the names of OpenEXR's standard attributes.
#pragma once

#include "render/image.h"
#include "render/settings.h"
#include "scenegraph/camera.h"

namespace occam::render {

/// Sets Image::is_light, worldToCamera (camera axes: right, up, back), worldToNDC (the frame is -1 to 1, y up),
/// chromaticities (Rec.709 and D65), comments, capDate and utcOffset.
void describe(Image& image, const Camera& camera, const Settings& settings);

}  // namespace occam::render
