// A texture in the form in which it is looked up: linear RGBA in half floats, with box-filtered levels, each in small square
// tiles.
//
// Memory   8 bytes a texel; each row of a tile of 8 x 8 has the size of a cache line, so that a bilinear lookup reads few.
// Threads  read only once it is made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scenegraph/material.h"

namespace occam {

class MipImage {
public:
    /// Makes an empty image; fill it row by row or column by column, then call build_levels().
    MipImage(int width, int height);

    int width() const noexcept { return levels_[0].width; }
    int height() const noexcept { return levels_[0].height; }
    int level_count() const noexcept { return static_cast<int>(levels_.size()); }
    std::size_t bytes() const noexcept;
    /// Returns the bytes that an image of this size will take with all its levels.
    static std::size_t bytes_of(int width, int height) noexcept;

    /// Writes a row or a column. A channel that is not a number becomes 0; one beyond the largest half float becomes that
    /// value. clamped_texels() counts both. One below 0 stays, and texels_below_0() counts it.
    void write_row(int y, std::span<const Vec4f> texels);
    void write_column(int x, std::span<const Vec4f> texels);
    void build_levels();
    /// Returns the number of texels given to these that had to be clamped.
    std::size_t clamped_texels() const noexcept { return clamped_texels_; }
    /// Returns the number of texels given to these of which a red, green or blue channel was below 0.
    std::size_t texels_below_0() const noexcept { return texels_below_0_; }
    /// Returns the largest red, green and blue of all texels given to these, as they were clamped, and at least 0.
    Vec3f brightest() const noexcept { return brightest_; }

    Vec4f texel(int level, int x, int y) const noexcept { return levels_[static_cast<std::size_t>(level)].texel(x, y); }
    /// Returns the four half floats of a texel.
    const std::uint16_t* halves(int level, int x, int y) const noexcept
    {
        return levels_[static_cast<std::size_t>(level)].at(x, y);
    }
    /// Returns the bilinear or the nearest texel about `st` of a level. `st` is finite; (0, 0) is the top left corner.
    Vec4f lookup(int level, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest) const noexcept;

private:
    struct Level {
        Level(int width_texels, int height_texels);
        const std::uint16_t* at(int x, int y) const noexcept { return &halves[offset(x, y)]; }
        Vec4f texel(int x, int y) const noexcept;
        void write_row(int y, std::span<const Vec4f> texels);
        void write_column(int x, std::span<const Vec4f> texels);
        std::size_t offset(int x, int y) const noexcept;

        int width, height, tiles_x;
        std::vector<std::uint16_t> halves;
    };
    static Level halved(const Level& from);
    void count(std::span<const Vec4f> texels) noexcept;

    std::vector<Level> levels_;
    std::size_t clamped_texels_ = 0, texels_below_0_ = 0;
    Vec3f brightest_{0};
};

}  // namespace occam
