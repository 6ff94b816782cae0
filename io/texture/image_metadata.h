// Removal of descriptive metadata from image files, and what else a library would misread.
#pragma once

#include <cstddef>
#include <optional>
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

/// What a TIFF says of its pixels (TIFF 6.0, sec. 8 and 18).
struct TiffPixels {
    static constexpr std::size_t kWhiteIsZero = 0, kGrey = 1, kRgb = 2, kInks = 5, kLab = 8, kLastLab = 10;

    std::size_t kind = kGrey;            ///< what the samples are (PhotometricInterpretation)
    std::size_t bits = 1, samples = 1;   ///< bits of a sample, and samples of a pixel
    std::size_t extra = 0;               ///< how many of these are no colours
    std::optional<std::size_t> alpha{};  ///< the first of those that is said to be alpha
    bool is_multiplied = false;          ///< the colours are multiplied by it (an "associated alpha")
};
TiffPixels pixels_of_tiff(std::vector<std::byte>& file);

}  // namespace occam
