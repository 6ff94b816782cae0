// How long the file of an image may be that is read into memory as a whole, by what its first bytes declare.
#pragma once

#include <cstdint>
#include <string_view>

#include "io/texture/image_header.h"
#include "io/texture/open_image.h"

namespace occam {

/// What a file may hold beside the samples of its picture: profiles, previews, layers, further pages or frames.
inline constexpr std::uintmax_t kMostBytesBesidePicture = std::uintmax_t(512) << 20;

/// Returns the most bytes that are read of a PNG, JPEG, TIFF, GIF, TGA, DDS or PNM (`format` as given by image_format()):
/// those that its format can need for the samples of a picture of the size that the file declares, within the limits, and
/// kMostBytesBesidePicture. A file that declares no size where its format has it may have these alone.
std::uintmax_t most_bytes_of_file(ImageBytes& file, std::string_view format, const ImageLimits& limits);

}  // namespace occam
