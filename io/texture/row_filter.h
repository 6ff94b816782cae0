// A box filter that makes the finest level of a texture while the rows of its image are read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/texture/mip_image.h"
#include "io/texture/orientation.h"

namespace occam {

/// Shrinks an image by any ratio of 1 or more along either axis, so that the whole image always fills the whole texture.
/// Each texel is the mean of the texels that lie under it, and those that lie under it in part count in proportion.
///
/// Memory   one row of the texture, and a weight for each column of the image. Borrows the texture.
class RowFilter {
public:
    /// width, height   of the image, and as the file has them: its rows may be columns of the texture
    /// to              is no larger than the image
    RowFilter(int width, int height, MipImage& to, Orientation orientation = {});

    /// Takes the next row of the image; the rows of the texture that end with it are written.
    void add(std::span<const Vec4f> row);

private:
    /// The weight of a texel of the image under a texel of the texture: 1 if it lies there as a whole.
    struct Tap {
        int texel;
        float weight;
    };
    void add_part(std::span<const Vec4f> row, float weight) noexcept;
    void write();

    MipImage& to_;
    Orientation orientation_;
    int columns_, rows_;              // of the texture, as the file has them
    std::int64_t height_, next_ = 0;  // rows of the image
    int out_ = 0;                     // the row of the texture that is being summed
    std::vector<Tap> taps_;
    std::vector<std::size_t> ends_;  // of each column of the texture, in taps_
    std::vector<Vec4f> sums_, means_;
    float area_;  // the number of the image's texels under one of the texture
};

}  // namespace occam
