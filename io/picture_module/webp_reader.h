// Reads WebP pictures through libwebp. OpenImageIO's reader of them multiplies colours by alpha, whatever it is asked for,
// and eight bits do not hold what undoing that would need.
//
// Threads  any. A reader serves one caller at a time.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/picture_codec.h"

namespace occam {

/// Opens a WebP file in memory, of which an animation counts as its first frame on an empty canvas. The picture is
/// decoded when its first rows are read, so the caller has to find its size acceptable first. Returns null and says why in
/// `error` if the parts of the file do not fit together, or if there is no memory for a list of them, since the library does
/// not tell these apart. Throws std::bad_alloc if there is none for the pixels.
/// bytes   of the file, borrowed as long as the reader lives
std::unique_ptr<PictureReader> open_webp(std::span<const std::byte> bytes, std::string& error);

/// The same; the reader keeps the bytes.
std::unique_ptr<PictureReader> open_webp(std::vector<char> bytes, std::string& error);

}  // namespace occam
