// Textures made by rule. The pixels come from integer hashes and base/maths.h alone, so they are the same on every machine.
// The colours are linear.
#pragma once

#include "scenegraph/texture.h"

namespace occam::builtin {

/// Returns marble tiles of two alternating colours, with joints. The texture repeats and covers `kTilesAcross` by as many
/// tiles.
Texture tiles();
inline constexpr int kTilesAcross = 4;

/// Returns wood grain along u, for boxes whose sides run from 0 to 1.
Texture wood();

/// Returns a glazed pattern of bands and a row of drops that goes around a vessel (u) and up it (v, 0 at the foot).
Texture glaze();

/// Returns an equirectangular picture of a dim room with two soft windows and a bright strip, which polished objects mirror.
Texture studio();

}  // namespace occam::builtin
