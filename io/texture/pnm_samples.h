// Samples of PPM and PGM files with fewer values than a byte has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/texture/image_header.h"

namespace occam {

/// What the head of a PGM or PPM says (Netpbm's "pgm" and "ppm").
struct PnmHead {
    bool is_text = false;
    int channels = 1;
    std::uint32_t width = 0, height = 0, most = 0;  ///< the largest value of a sample
    std::size_t samples_at = 0;                     ///< where the samples begin in the file
};

/// Reads the head of a PGM or PPM whose largest sample is below 255. Returns nothing for other files.
std::optional<PnmHead> read_head_of_few_values(ImageBytes& bytes);

/// Returns such a file with samples of 16 bits. OpenImageIO makes bytes of them by division without a remainder, which is up
/// to a step too dark. A sample that is larger than the head allows is the largest; what is cut off stays so.
std::vector<std::byte> with_many_values(std::span<const std::byte> file, const PnmHead& head);

}  // namespace occam
