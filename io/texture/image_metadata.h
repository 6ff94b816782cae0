// Removal of descriptive metadata from image files, and what else a library would misread.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "io/texture/orientation.h"

namespace occam {

/// Removes colour profiles, EXIF and texts from a PNG, JPEG or TIFF (`format` as given by image_format()), in place, since
/// files may be long: OpenImageIO 2.4 reads profiles past their end, and nothing here uses them. Parts that break the
/// format's rules stay as they are. In a TIFF that leaves out its bits per sample, whose default OpenImageIO takes to be 8,
/// they are 1 afterwards, as the format says. Files of other formats stay as they are. A PNG must not be cut off.
void remove_metadata(std::vector<std::byte>& file, std::string_view format);

/// Returns how the rows of a TIFF lie, by its tag Orientation (TIFF 6.0, sec. 8), and makes the tag say that they begin at
/// the top left: of some kinds of pixels libtiff turns the rows, of others it does not.
Orientation take_tiff_orientation(std::vector<std::byte>& file);

/// Returns whether a TIFF says that its colours are multiplied by its alpha: the first sample of a pixel that is no colour
/// is an "associated alpha" (TIFF 6.0, sec. 18).
bool has_multiplied_colors_tiff(std::vector<std::byte>& file);

}  // namespace occam
