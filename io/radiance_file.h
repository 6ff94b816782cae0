// Reads Radiance pictures (.hdr), which environments usually are, without the library behind io/picture_codec.h: loading
// that takes longer than many pictures do.
//
// Threads  a reader serves one caller at a time.
#pragma once

#include <filesystem>
#include <memory>

#include "io/picture_codec.h"

namespace occam {

/// Opens a picture of the usual kind: colours of 32 bits (RGBE), rows from the top, columns from the left, and neither gamma
/// nor exposure in its header. Returns null for any other file, which picture_codec() may know to read.
std::unique_ptr<PictureReader> open_radiance(const std::filesystem::path& file);

}  // namespace occam
