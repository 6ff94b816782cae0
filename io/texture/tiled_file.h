// Texture files of which single tiles can be read: a tiled OpenEXR file with all MIP levels of a texture, made by
// `occam texture`.
//
// The texels are those that decoding and filtering the original image gives, bit for bit: linear RGBA in half floats. So it
// does not change a picture whether a file is kept in memory as a whole (TextureSource reads it as any other image) or read
// tile by tile.
//
// Threads  any thread may read tiles; those of one file are read one after the other.
// Errors   Error names the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/picture_codec.h"
#include "io/texture/mip_image.h"

namespace occam {

/// Holds a tile of 64 x 64 texels, or of fewer at the right and at the bottom of a level.
struct TextureTile {
    static constexpr int kSide = 64;

    TextureTile(int tile_width, int tile_height)
        : width(tile_width), halves(std::size_t(tile_width) * std::size_t(tile_height) * 4)
    {
    }
    /// Returns the four half floats of a texel, counted from the tile's corner.
    std::uint16_t* at(int x, int y) noexcept { return &halves[(std::size_t(y) * std::size_t(width) + std::size_t(x)) * 4]; }
    const std::uint16_t* at(int x, int y) const noexcept { return const_cast<TextureTile*>(this)->at(x, y); }
    std::size_t bytes() const noexcept { return sizeof *this + halves.size() * sizeof(std::uint16_t); }

    int width;
    std::vector<std::uint16_t> halves;
};

class TiledFile {
public:
    /// Writes a texture. Throws Error of Kind::Output.
    static void write(const MipImage& image, const std::filesystem::path& file);
    /// Returns whether an opened picture says that write() has made it.
    static bool is_one(const PictureReader& picture);

    /// Opens nothing yet.
    /// width, height   of the finest level
    TiledFile(std::filesystem::path file, std::string name, int width, int height);
    ~TiledFile();

    int width() const noexcept { return width_; }
    int height() const noexcept { return height_; }
    int level_count() const noexcept;
    int level_width(int level) const noexcept;
    int level_height(int level) const noexcept;
    /// Tells this object apart from all others of the process.
    std::uint64_t number() const noexcept { return number_; }

    /// Reads the tile in that column and row of the level's tiles. Throws Error if the file is not there any more, is
    /// damaged, or is not of the size that was given.
    TextureTile read(int level, int column, int row);

private:
    struct Open;
    std::filesystem::path file_;
    std::string name_;
    int width_, height_;
    std::uint64_t number_;
    std::unique_ptr<Open> open_;
};

}  // namespace occam
