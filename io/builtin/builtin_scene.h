// The built-in scene needs no file: it is a still life of cages made in code.
#pragma once

#include "scenegraph/scene.h"

namespace occam {

/// Returns a new copy of the scene, with a camera "main" of aspect ratio 16 : 9. This takes some hundredths of a second and
/// gives the same bits on every machine.
///
/// The scene shows what the engine is for: smooth cages with infinite and semi-sharp creases, extraordinary vertices and
/// faces of many corners, textures, instances with materials of their own, soft shadows from area lights, and an
/// environment.
Scene builtin_scene();

}  // namespace occam
