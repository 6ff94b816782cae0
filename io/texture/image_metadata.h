// Image files without what only describes them.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace occam {

/// A copy of a PNG, JPEG or TIFF (`format` as of image_format()) without colour profiles, EXIF and texts: OpenImageIO 2.4
/// reads profiles past their end, and nothing here wants them. Parts that break the format's rules are copied as they are.
/// Other formats: a copy. A PNG must not be cut off.
std::vector<std::byte> without_metadata(std::span<const std::byte> file, std::string_view format);

}  // namespace occam
