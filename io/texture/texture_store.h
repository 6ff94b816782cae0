// Textures ready for lookup: each is decoded once, made linear, and kept as half-float MIP levels.
//
// Memory   at most the cap given at construction; a texture that would pass it is halved until it fits. Owned by a renderer.
// Threads  prepare() by one thread (it decodes on several); sample() from any after that, without locks.
// Errors   a texture that cannot be read is magenta and black squares, and a warning that counts; nothing throws.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenegraph/material.h"
#include "scenegraph/texture.h"

namespace occam {

class MipImage;
class Scene;

class TextureStore {
public:
    explicit TextureStore(std::size_t cap_bytes);
    ~TextureStore();

    /// Makes every texture of the scene known, decoding what is new (before the first tile), and forgets all others.
    void prepare(const Scene& scene);

    /// Filtered texel of `use` at texture coordinates `uv` (before the use's own transform), linear RGBA.
    /// White for no texture, or one that was not there at prepare(). Coordinates that are not finite count as 0.
    /// width    of the filter in units of uv; 0: bilinear texels of the finest level (how the references are made)
    Vec4f sample(const TextureUse& use, Vec2f uv, float width) const noexcept;

    /// Of a texel of the finest level, in units of uv; 0 where sample() gives white.
    float texel_width(const TextureUse& use) const noexcept;

    std::size_t bytes() const noexcept;
    std::vector<std::string> warnings() const;

private:
    struct State;
    const MipImage* image(TextureId id) const noexcept;
    std::unique_ptr<State> state_;
};

}  // namespace occam
