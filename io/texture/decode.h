// Decoding of image files into linear texels.
#pragma once

#include <memory>
#include <string>

#include "io/texture/decode_budget.h"
#include "io/texture/mip_image.h"
#include "scenegraph/texture.h"

namespace occam {

/// Larger images are refused before they are decoded.
inline constexpr int kMaxTextureSide = 16384;
inline constexpr std::size_t kMaxTextureTexels = std::size_t(1) << 27;

/// Holds one opened image: its size is known, its texels are not read yet.
class TextureSource {
public:
    /// Borrows the texture. Throws Error if the file cannot be read, is too large, or has scans for which the budget, if
    /// one is given, has nothing left.
    explicit TextureSource(const Texture& texture, DecodeBudget* budget = nullptr);
    ~TextureSource();
    TextureSource(TextureSource&&) noexcept;

    int width() const noexcept;
    int height() const noexcept;
    /// Returns whether single tiles of it can be read, with all its levels (TiledFile).
    bool is_tiled_file() const noexcept;
    /// Returns the bytes that decoding all texels produces before they are filtered, at least four for each texel; 0 for
    /// texels that are in memory. Time to decode follows them.
    std::uintmax_t bytes_to_decode() const noexcept;
    /// Returns whether its texels have an alpha of their own.
    bool has_alpha() const noexcept;
    /// Returns whether `occam texture` made the file of an image of colours and the texture is none, or the reverse.
    bool has_texels_of_another_role() const noexcept;
    /// Returns all texels, linear, with all levels; a box filter divides the sides by 2^halvings (to at least 1) while the
    /// file is read. Throws Error.
    /// multiplies_by_alpha   whether colours are multiplied by their alpha before that
    MipImage decode(int halvings, bool multiplies_by_alpha = false) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam
