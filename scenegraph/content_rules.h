// The validation of what an application or an importer adds to the scene graph. All later code may rely on numbers that are
// finite and in range.
#pragma once

#include "scenegraph/animation.h"
#include "scenegraph/camera.h"
#include "scenegraph/light.h"
#include "scenegraph/material.h"

namespace occam {

// Each function throws an Error that names the value and the rule it breaks.
void check(const Material& material);
void check(const Light& light);
void check(const CameraLens& lens);
/// Checks that the keys of a camera are finite, and that there are none, or from 2 to kMaxCameraKeys.
void check(const Camera& camera);
/// Checks that the moments are finite, not too far away, and in order.
void check(const Shutter& shutter);
/// Checks sizes, widths, increasing times, finite values, and that rotations have a length. The targets are not checked.
void check(const Clip& clip);
void check(const Trs& place, const std::string& name);
void check(const Environment& environment);

}  // namespace occam
