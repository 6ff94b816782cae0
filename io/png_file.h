// Writes PNG pictures, and reads their heads, through libpng, which is loaded with Occam. The library behind
// io/picture_codec.h knows all formats, but loading it takes longer than many pictures do.
//
// Threads  any.
#pragma once

#include <optional>
#include <string>

#include "io/picture_codec.h"
#include "io/texture/image_header.h"

namespace occam {

struct PngPicture {
    int width = 0, height = 0;
    int channels = 3;     ///< 3, or 4 with alpha, which is not multiplied into the colours
    bool is_srgb = true;  ///< false: the values are linear
    std::string description;
};

/// Encodes rows of interleaved values of 0 to 1, from the top, with 8 bits each; NaN is 0. Returns what went wrong, or
/// nothing. Throws std::bad_alloc.
std::string write_png(const PngPicture& picture, const float* values, PictureBytes& to);

/// Reads what comes before the values. Returns nothing if that is not the head of a PNG. The number of channels and the
/// colour space are those of the file, whatever writes it.
std::optional<PngPicture> read_png_head(ImageBytes& file);

}  // namespace occam
