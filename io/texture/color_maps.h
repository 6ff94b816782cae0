// Completion of the colour maps of image files.
//
// A pixel of a GIF or of a TGA may be the number of a colour, and the file decides how many colours there are. OpenImageIO
// 2.4 does not compare the two, and reads what lies in memory behind the map.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "io/texture/image_header.h"

namespace occam {

/// Returns whether pixels of a GIF or of a TGA (`format` as given by image_format()) are numbers of colours. It reads the
/// header alone.
bool has_color_numbers(ImageBytes& bytes, std::string_view format);

/// Returns true if the file is a TGA whose pixels are numbers of colours but not of eight bits, or whose colours have a size
/// that the format does not know.
bool has_foreign_color_map_tga(ImageBytes& bytes);

/// Returns a copy of a GIF or a TGA in which each number that a pixel may hold has a colour: the file's, or black if it has
/// none. Only the first picture of a GIF is looked at, and a file that is cut off before its pixels is copied as it is.
std::vector<std::byte> with_whole_color_map(std::span<const std::byte> file, std::string_view format);

}  // namespace occam
