// Textures by rule: pixels from integer hashes and base/maths.h alone, so the same everywhere. Linear colours.
#pragma once

#include "scenegraph/texture.h"

namespace occam::builtin {

/// Marble tiles of two colours in turn, with joints; repeats. Covers `kTilesAcross` by as many tiles.
Texture tiles();
inline constexpr int kTilesAcross = 4;

/// Grain along u, for boxes whose sides run from 0 to 1.
Texture wood();

/// A glazed pattern that goes around a vessel (u) and up it (v, 0 the foot): bands and a row of drops.
Texture glaze();

/// A dim room with two soft windows and a bright strip, equirectangular: what polished things mirror.
Texture studio();

}  // namespace occam::builtin
