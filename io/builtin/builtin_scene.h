// The scene that is there without any file: a still life of cages made in code.
#pragma once

#include "scenegraph/scene.h"

namespace occam {

/// A new copy of it, with a camera "main" of 16 : 9. Takes some hundredths of a second; the same bits on every machine.
///
/// It shows what the engine is for: smooth cages with infinite and semi-sharp creases, extraordinary vertices and faces of
/// many corners, textures, instances with materials of their own, soft shadows from area lights, an environment.
Scene builtin_scene();

}  // namespace occam
