// Writes OpenEXR files of scanlines, without the library behind io/picture_codec.h: loading that takes longer than many
// pictures do.
//
// The files have what pictures of Occam need (OpenEXR's "File Layout", version 2): one part, blocks of sixteen lines that
// are compressed by ZIP, channels of half or float, and attributes of text, numbers and matrices.
//
// Threads  any.
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "io/picture_codec.h"

namespace occam {

/// Encodes interleaved floats. The channels may come in any order, and have the types of spec.channel_types, Half or Float.
/// A value that is too large for a half becomes infinite.
void write_exr(const PictureSpec& spec, std::span<const PictureAttribute> attributes, const float* pixels, PictureBytes& to);

/// What the head of a file says of its picture.
struct ExrHead {
    int width = 0, height = 0, channel_count = 0;
};
/// Reads the head of a file, or returns nothing if it is not a whole one.
std::optional<ExrHead> read_exr_head(const std::filesystem::path& file);

}  // namespace occam
