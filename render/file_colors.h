// Says how the colours of picture files are encoded.
#pragma once

#include "io/texture/image_header.h"

namespace occam::render {

/// Returns by which power the values of a PNG become linear: 1 if they are linear already, and 0 if they are sRGB, as those
/// of a file that says nothing are. Files that name the power of sRGB nearly, 2.2, mean sRGB.
float png_power(ImageBytes& file);

}  // namespace occam::render
