// Writes and reads PNG pictures through libpng, which is loaded with Occam. The library behind
// io/picture_codec.h knows all formats, but loading it takes longer than many pictures do, and it prints what libpng finds
// wrong on standard error.
//
// Threads  any. A reader serves one caller at a time.
#pragma once

#include <memory>
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

/// Opens a PNG of any kind. Its values are of 8 or 16 bits, and palettes and transparent colours are resolved, as the codec
/// does it. An interlaced picture is decoded whole when its first rows are read, so the caller has to find its size
/// acceptable first. Returns null and says why in `error` if its head cannot be read.
std::unique_ptr<PictureReader> open_png(ImageBytes file, std::string& error);

}  // namespace occam
