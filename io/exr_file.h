// Writes OpenEXR pictures and reads plain ones through OpenEXR's own library, which is loaded with Occam. The library behind
// io/picture_codec.h knows all formats, but loading it takes longer than many pictures do.
//
// Files that are written have one part of scanlines, which are compressed by ZIP.
//
// Threads  any, and the library starts none. A PictureReader serves one caller at a time.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "io/picture_codec.h"
#include "io/texture/image_header.h"

namespace occam {

/// Encodes interleaved floats. The channels may come in any order, and have the types of spec.channel_types, Half or Float.
/// A value that is too large for a half becomes infinite. Returns what went wrong, or nothing.
std::string write_exr(const PictureSpec& spec, std::span<const PictureAttribute> attributes, const float* pixels,
                      PictureBytes& to);

/// Holds what the first header of a file says of its picture.
struct ExrHead {
    int width = 0, height = 0, channel_count = 0;
    std::int64_t tile_width = 0, tile_height = 0;  ///< 0: the file has no tiles
    std::string text;                              ///< the attribute that was asked for
};
/// Reads the first header of a file, with one of its text attributes, and allocates nothing for the pixels. Returns nothing
/// if the header is not valid.
std::optional<ExrHead> read_exr_head(ImageBytes& file, const char* attribute = "");

/// Returns whether the last row of a file of one part can be read; true for files of several parts. The library allocates
/// room for some rows, as it does for open_exr().
bool has_last_row(ImageBytes file);

/// Opens a plain picture: a single part that is not deep, of scanlines or of small tiles (of their finest level), with the
/// channels R, G, B and perhaps A, or with Y alone, in floats or halves and without subsampling. Returns null for any other
/// file, and for one that the library refuses: picture_codec() may know to read it, or to say what is wrong. The library
/// allocates room for some rows, so the caller has to find the size of read_exr_head() acceptable first.
std::unique_ptr<PictureReader> open_exr(ImageBytes file);

}  // namespace occam
