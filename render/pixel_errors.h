// The errors of a tile's pixels, from which follows where samples are still needed.
//
// Threads  everything is a function of its arguments.
#pragma once

#include <span>

#include "render/film.h"
#include "render/tiles.h"

namespace occam::render {

/// Computes for each pixel of a tile the root mean square of the relative errors (PixelSums::relative_error) of the 3 x 3
/// pixels around it, as far as they belong to the same tile. One pixel's samples may miss by chance what its neighbours'
/// samples have found (Mitchell 1987 looks at several pixels at once, too).
/// pixels   those of the tile, as pixels_of() orders them
/// sums     one for each pixel
/// errors   one for each pixel, which is written
void errors_around(const PixelRect& tile, std::span<const Pixel> pixels, std::span<const PixelSums> sums,
                   std::span<float> errors);

}  // namespace occam::render
