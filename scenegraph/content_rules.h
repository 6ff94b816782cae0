// What the scene graph asks of what an application or an importer gives it: so that everything behind it may rely on numbers
// being finite and in range.
#pragma once

#include "scenegraph/animation.h"
#include "scenegraph/camera.h"
#include "scenegraph/light.h"
#include "scenegraph/material.h"

namespace occam {

// Each throws Error that names the value and the rule it breaks.
void check(const Material& material);
void check(const Light& light);
void check(const CameraLens& lens);
/// Sizes, widths, rising times, finite values, rotations with a length. Targets are not looked at.
void check(const Clip& clip);
void check(const Trs& place, const std::string& name);
void check(const Environment& environment);

}  // namespace occam
