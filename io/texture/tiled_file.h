// Texture files of which single tiles can be read: a tiled OpenEXR file with all MIP levels of a texture, made by
// `occam texture`.
//
// The texels are those that decoding and filtering the original image gives, bit for bit: linear RGBA in half floats. So it
// does not change a picture whether a file is kept in memory as a whole (TextureSource reads it as any other image) or read
// tile by tile.
//
// Memory   some 100 KB for each file that is open, and 8 bytes for each of its tiles. The process keeps at most 256 files
//          open, or a quarter of those that it may open.
// Threads  any thread may read tiles; those of one file are read one after the other.
// Errors   Error names the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "io/picture_codec.h"
#include "io/texture/mip_image.h"
#include "scenegraph/texture.h"

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
    /// role   of the image from which the texels were decoded
    static void write(const MipImage& image, TextureRole role, const std::filesystem::path& file);
    /// Returns whether an opened picture says that write() has made it, and has the form that write() gives.
    static bool is_one(const PictureReader& picture);
    /// Returns whether the colours of an OpenEXR file are not multiplied by alpha: those of these files, also where another
    /// program has written them again in another form.
    static bool keeps_colors_apart(const PictureReader& picture);
    /// Returns the role with which write() has made such a picture.
    static TextureRole role_of(const PictureReader& picture);

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

    /// Is held while a tile of this file is read.
    std::mutex& reading() noexcept { return reading_; }
    /// Reads the tile in that column and row of the level's tiles; the caller holds reading(). Halves that are no finite
    /// numbers become what MipImage makes of them. Throws Error if the file is not there any more, is damaged, or is not of
    /// the size that was given.
    TextureTile read(int level, int column, int row);
    /// Reads all tiles and throws what read() throws; the caller does not hold reading().
    void check();

private:
    struct Open;
    std::filesystem::path file_;
    std::string name_;
    int width_, height_;
    std::uint64_t number_;
    std::mutex reading_;
    std::unique_ptr<Open> open_;  ///< null: the file is closed
};

}  // namespace occam
