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
#include "io/texture/decode_budget.h"
#include "io/texture/orientation.h"

namespace occam {

/// The largest image that is read.
struct ImageLimits {
    std::uintmax_t side, texels;
    std::uintmax_t values;  ///< texels times channels
    /// The same for a file of less than a byte for 16 values, where a texel counts as four values at least.
    std::uintmax_t values_of_few_bytes;
};

/// An opened image. Its reader may refer to the bytes.
struct OpenImage {
    std::vector<std::byte> bytes;
    std::unique_ptr<PictureReader> reader;
    /// What the head of a Radiance file ("-Y 512 +X 1024") or the tag Orientation of a TIFF says. The rows of other formats
    /// begin at the top left for what reads them here.
    Orientation orientation;
    /// Whether the colours are stored multiplied by alpha. A TIFF, TGA or DDS says so, and OpenEXR has that convention; only
    /// files that `occam texture` wrote keep them apart. Samples of whole numbers are multiplied as they are, in sRGB.
    bool has_multiplied_colors = false;
    /// Whether two channels are red and green, and not grey and alpha.
    bool has_two_colors = false;
};

/// Returns whether so many texels are more than an honest file of that size holds: few bytes may declare many texels.
bool declares_too_much(std::uintmax_t texels, std::uintmax_t file_bytes) noexcept;

/// Opens an image file; if `encoded` is given, the image is in memory. The image is flat, not deep, and within the limits.
/// The codec's readers allocate up to a tile of 2^26 values, or a row of tiles.
/// name     of the image, for errors
/// budget   if given, that of all images of a scene: the library works through all scans of a JPEG when it opens one, so
///          they are charged before that
/// Throws   Error if its format is not read, it is damaged, or it breaks the limits or the budget.
OpenImage open_image(const std::filesystem::path& file, const std::vector<std::byte>* encoded, const std::string& name,
                     const ImageLimits& limits, DecodeBudget* budget = nullptr);

}  // namespace occam
