// Image files into linear texels, by OpenImageIO: the only place that knows it here.
#pragma once

#include <memory>
#include <string>

#include "io/texture/mip_image.h"
#include "scenegraph/texture.h"

namespace occam {

/// Larger images are refused before they are decoded.
inline constexpr int kMaxTextureSide = 16384;
inline constexpr std::size_t kMaxTextureTexels = std::size_t(1) << 27;

/// One image, opened: its size is known, its texels are not read yet.
class TextureSource {
public:
    /// Throws Error: the file cannot be read, or is too large.
    explicit TextureSource(const Texture& texture);
    ~TextureSource();
    TextureSource(TextureSource&&) noexcept;

    int width() const noexcept;
    int height() const noexcept;
    /// All texels, linear, with all levels; sides divided by 2^halvings (at least 1) by a box filter while it reads.
    /// Throws Error.
    MipImage decode(int halvings) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam
