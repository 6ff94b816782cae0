// One texture of a TextureStore: what is known of its image, and its texels once a lookup has asked for them.
//
// Threads  keep() is called before the first lookup; image(), fail() and what asks for counts and messages may be called by
//          any thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <vector>

#include "io/texture/decode_budget.h"
#include "io/texture/mip_image.h"
#include "io/texture/tiled_file.h"
#include "scenegraph/texture.h"

namespace occam {

/// Says how a texture is kept in memory.
struct TextureKeeping {
    int halvings = 0;
    bool is_in_tiles = false;  ///< its tiles are read one by one
    bool is_weighted = false;  ///< colours are filtered with their alpha as weight, and multiplied by it in memory
    friend bool operator==(const TextureKeeping&, const TextureKeeping&) = default;
};

/// Holds one texture that the store knows; it is decoded when it is first asked for.
class TextureEntry {
public:
    /// Opens the image to learn its size. Throws std::bad_alloc alone: a missing texture has a warning and no size, and one
    /// that cannot be opened has an error and no size.
    /// texture      is shared with the scene until it is decoded, and not copied
    /// has_failed   is set if the image cannot be read, now or later; it must outlive the entry
    /// budget       of all images of the scene
    TextureEntry(std::shared_ptr<const Texture> texture, std::atomic<bool>& has_failed, DecodeBudget& budget);

    /// Returns the bytes of the image with all its levels, if it is halved that often; 0 if it cannot be opened.
    std::size_t bytes_of(int halvings) const;
    bool is_readable() const { return width_ > 0; }
    std::uint64_t identity() const { return identity_; }
    /// Returns the bytes that decoding will make, one for each texel of a tiled file, of which few may be looked up, and the
    /// bytes of the file from which they come; both are 0 for texels that are in memory.
    std::uintmax_t bytes_to_decode() const { return bytes_to_decode_; }
    std::uintmax_t file_bytes() const { return file_bytes_; }
    bool is_tiled_file() const { return is_tiled_file_; }
    bool has_alpha() const { return has_alpha_; }
    int width() const { return std::max(1, width_ >> keeping_.halvings); }
    int height() const { return std::max(1, height_ >> keeping_.halvings); }
    TextureKeeping keeping() const { return keeping_; }
    /// Says how the image will be kept. It may be called once, before the first lookup.
    void keep(TextureKeeping how);
    /// Reads all tiles of an image that is kept in tiles, so that errors() knows whether they can be read.
    void check_tiles() noexcept;
    /// Returns the file of an image that is kept in tiles, else null.
    TiledFile* tiles() const { return tiles_.get(); }
    /// Returns whether a tile could not be read; no other is to be asked for then.
    bool is_broken() const noexcept { return is_broken_; }
    /// Remembers why a tile could not be read.
    void fail(const std::exception& error) noexcept;

    /// Returns the image, and decodes it if this is the first call. Callers from other threads wait for it.
    const MipImage& image(const MipImage& unreadable);
    std::size_t decoded_bytes() const
    {
        const std::lock_guard lock(decoding_);
        return decoded_ ? decoded_->bytes() : 0;
    }
    /// Returns the largest red, green and blue of its texels; 0 if they were not decoded or are read in tiles.
    Vec3f brightest() const
    {
        const std::lock_guard lock(decoding_);
        return decoded_ ? decoded_->brightest() : Vec3f(0);
    }
    double decode_seconds() const
    {
        const std::lock_guard lock(decoding_);
        return decode_seconds_;
    }
    /// Returns whether it could not be read, as far as is known. The next frame may read it: there may be more memory then,
    /// or the file may have been repaired.
    bool has_failed() const
    {
        const std::lock_guard lock(decoding_);
        return lacks_memory_ || !errors_.empty();
    }
    std::vector<std::string> warnings() const
    {
        const std::lock_guard lock(decoding_);
        return warnings_;
    }
    std::vector<std::string> errors() const
    {
        const std::lock_guard lock(decoding_);
        if (lacks_memory_) throw std::bad_alloc();
        return errors_;
    }

private:
    void decode();
    void add_error(const std::exception& error) noexcept;

    std::atomic<const MipImage*> ready_{nullptr};
    std::shared_ptr<const Texture> source_;  ///< null from when it is decoded
    const std::string name_;
    const std::uint64_t identity_;
    const TextureRole role_;
    std::atomic<bool>& has_failed_;
    int width_ = 0, height_ = 0;
    bool is_tiled_file_ = false, has_alpha_ = false;
    TextureKeeping keeping_;
    std::unique_ptr<TiledFile> tiles_;
    std::atomic<bool> is_broken_ = false;  ///< a tile could not be read
    std::uintmax_t bytes_to_decode_ = 0, file_bytes_ = 0;
    mutable std::mutex decoding_;  // guards the members below
    std::unique_ptr<const MipImage> decoded_;
    std::vector<std::string> warnings_, errors_;
    double decode_seconds_ = 0;
    bool lacks_memory_ = false;
};

}  // namespace occam
