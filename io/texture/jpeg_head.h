// What a JPEG declares, read before its library runs: that allocates for the declared size and works through all scans of a
// file when it opens one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace occam {

struct JpegHead {
    std::uint32_t width = 0, height = 0;  ///< the largest of all frame headers
    std::size_t scans = 0;                ///< a scan may visit each block of the picture, whatever its length is
};

/// Returns nothing if there is no frame header (ITU T.81, annex B).
std::optional<JpegHead> jpeg_head(std::span<const std::byte> file);

}  // namespace occam
