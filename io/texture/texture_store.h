// The textures of a scene, ready for lookup: each is decoded when a lookup first asks for it, made linear, and kept as
// half-float MIP levels.
//
// Memory   at most the cap given at construction, if all textures fit into it once each is halved down to a single tile,
//          and 2 MB of tiles beside them. The sizes of all textures of the scene are known before the first lookup. Those
//          whose files `occam texture` has made (TiledFile) are read tile by tile, which changes no texel. If the others
//          would not all fit into what the tiles leave, at least three quarters, the largest are halved until they do. So a
//          picture depends neither on which textures are decoded nor on those of earlier frames. A renderer owns the store.
//          What the scene holds in memory, pixels or the bytes of a file, is not copied: the store shares it, also after the
//          scene has removed it, until it is decoded or prepare() forgets it.
// Alpha    a texture that only cuts out materials (Scene::is_cut_out_by()) is filtered with alpha as the weight of its
//          colours, so that what lies under its transparent texels is seen nowhere.
// Threads  prepare() is called by one thread while no other looks up. After that any number of threads may call sample().
//          The first lookup in a texture decodes it under a lock of that texture alone, so several are decoded at a time.
// Errors   a texture without a file is grey, with a warning. One whose file or bytes are no image that can be read is grey
//          too and stands in errors(), for the caller to refuse. The next prepare() reads it again, since it may have been
//          repaired; a file that has been read is not read again, whatever becomes of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenegraph/material.h"
#include "scenegraph/texture.h"

namespace occam {

class Scene;

/// Returns what a difference of coordinates becomes by the transform of a use (KHR_texture_transform), which scales first
/// and then rotates.
Vec2f scaled_and_rotated(const TextureUse& use, Vec2f uv) noexcept;

class TextureStore {
public:
    explicit TextureStore(std::size_t cap_bytes);
    ~TextureStore();

    /// Makes every texture of the scene known, and forgets all others. Reads no more than the headers of those that are new
    /// or could not be read before.
    /// Throws Error if images would take minutes to decode, though their files are small.
    void prepare(const Scene& scene);
    /// Forgets all textures.
    void clear() noexcept;
    /// Decodes all known textures now, on several threads, and reads all tiles of those in tiles, so that errors() is then
    /// complete.
    void decode_all();

    /// Returns the filtered texel of `use` at texture coordinates `uv` (before the use's own transform), linear RGBA.
    /// Returns white for no texture, or for one that was absent at prepare(). Coordinates that are not finite count as 0.
    ///
    /// Filters are as wide along the image as across it. Where the width spans more texels one way than the other, as it
    /// does in an image that is not square or by a transform with two scales, their geometric mean counts, because the
    /// width is a mean over the directions of the surface, too.
    /// width    of the filter in units of u and v; 0: bilinear texels of the finest level (how the references are made)
    Vec4f sample(const TextureUse& use, Vec2f uv, Vec2f width) const noexcept;
    Vec4f sample(const TextureUse& use, Vec2f uv, float width) const noexcept { return sample(use, uv, Vec2f(width)); }

    /// Returns the width of a texel of the finest level, in units of uv; 0 where sample() gives white.
    float texel_width(const TextureUse& use) const noexcept;

    /// Returns whether all texels of the finest level are the same, as those of a single colour are. It looks at each of
    /// them until one differs.
    bool has_one_texel(const TextureUse& use) const;

    /// Returns the largest red, green and blue of all texels of the finest level, and at least 0. Returns white for no
    /// texture, and black for one that no lookup has asked for yet or that is read in tiles.
    Vec3f brightest(const TextureUse& use) const noexcept;

    /// Returns the identity of the texture as it was at prepare(), which tells its texels apart from those that it had
    /// before a Scene::replace(); 0 where sample() gives white.
    std::uint64_t identity(const TextureUse& use) const noexcept;

    /// Returns a hash of how often each texture is halved to fit the memory; 0 if none is.
    std::uint64_t halvings_hash() const noexcept;

    /// Returns the bytes of all decoded textures and of the tiles in memory.
    std::size_t bytes() const noexcept;
    /// Returns the seconds that threads have spent on decoding known textures and reading tiles, summed.
    double decode_seconds() const noexcept;
    /// Returns warnings: textures without a file, those that were halved, and those with texels that are clamped or
    /// below 0, in the order of the textures' identities.
    std::vector<std::string> warnings() const;
    /// Returns errors: textures that are not images or cannot be read, as far as they have been looked up, in the same
    /// order.
    std::vector<std::string> errors() const;
    /// Returns true if errors() may have something to say; it costs next to nothing.
    bool has_failed() const noexcept;
    /// Throws the first of errors() as an Error, if there is one: what was found with a stand-in for a texture does not
    /// count.
    void throw_if_failed() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace occam
