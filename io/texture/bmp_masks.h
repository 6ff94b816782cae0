// The masks of a BMP of 32 bits a pixel, which say which byte is red, green, blue and alpha. OpenImageIO 2.4 ignores them:
// it takes the bytes for blue, green, red and alpha.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/texture/image_header.h"

namespace occam {

/// The masks of red, green, blue and alpha in the number that the bytes of a pixel make, the lowest first; 0 where there is
/// none.
using BmpMasks = std::array<std::uint32_t, 4>;

/// Returns the masks of a BMP of 32 bits; the usual ones, without alpha, if it has none. Returns nothing for other files.
std::optional<BmpMasks> masks_of_bmp(ImageBytes& bytes);

/// Returns whether the bytes stand in the order that the library expects; of alpha there may be none.
bool are_usual(const BmpMasks& masks) noexcept;

/// Returns whether each of the masks is a byte of its own.
bool are_bytes(const BmpMasks& masks) noexcept;

/// Puts the bytes of a file's pixels into the usual order. The masks are bytes.
void put_in_usual_order(std::vector<std::byte>& file, const BmpMasks& masks);

}  // namespace occam
