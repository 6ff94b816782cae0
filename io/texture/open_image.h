// Opening of image files of all formats that are read. What a file declares is checked before a library allocates for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/picture_codec.h"

namespace occam {

/// The largest image that is read.
struct ImageLimits {
    std::uintmax_t side, texels;
    std::uintmax_t values;  ///< texels times channels
};

/// An opened image. Its reader may refer to the bytes.
struct OpenImage {
    std::vector<std::byte> bytes;
    std::unique_ptr<PictureReader> reader;
};

/// Says how the rows of a file lie in the picture.
struct Orientation {
    bool mirrors_rows = false;     ///< they run from the bottom
    bool mirrors_columns = false;  ///< the columns run from the right
};

/// Returns how the rows of a Radiance file lie: its head says it ("-Y 512 +X 1024"). Those of other formats begin at the top
/// left for what reads them here. Throws Error if it is stored column by column.
Orientation orientation_of(const PictureReader& image, const std::string& name);

/// Returns whether so many texels are more than an honest file of that size holds: few bytes may declare many texels.
bool declares_too_much(std::uintmax_t texels, std::uintmax_t file_bytes) noexcept;

/// Opens an image file; if `encoded` is given, the image is in memory. The image is flat, not deep, and within the limits.
/// The codec's readers allocate up to a tile of 2^26 values, or a row of tiles.
/// name     of the image, for errors
/// Throws   Error if its format is not read, it is damaged, or it breaks the limits.
OpenImage open_image(const std::filesystem::path& file, const std::vector<std::byte>* encoded, const std::string& name,
                     const ImageLimits& limits);

}  // namespace occam
