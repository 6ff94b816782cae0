#include "io/texture/mip_image.h"

#include <algorithm>
#include <cmath>

#include "base/half.h"
#include "base/half_lanes.h"
#include "base/simd.h"
#include "io/texture/texel_places.h"

namespace occam {

namespace {

constexpr int kTileBits = 3, kTile = 1 << kTileBits;

int tiles(int texels) noexcept { return (texels + kTile - 1) >> kTileBits; }

// Holds the texels of the finer level under one texel of the coarser level, along one axis, with their weights: an odd side
// gives three.
struct Taps {
    int first = 0, count = 0;
    float weight[3] = {};
};
Taps taps_of(int i, int from, int to) noexcept
{
    // Both ends are in units of 1/to texels, which is exact in integers.
    const std::int64_t lo = std::int64_t(i) * from, hi = lo + from;
    Taps taps;
    taps.first = static_cast<int>(lo / to);
    for (int x = taps.first; std::int64_t(x) * to < hi; ++x) {
        const std::int64_t overlap = std::min<std::int64_t>(hi, (std::int64_t(x) + 1) * to) -
                                     std::max<std::int64_t>(lo, std::int64_t(x) * to);
        taps.weight[taps.count++] = static_cast<float>(overlap) / static_cast<float>(from);
    }
    return taps;
}

// Returns where the texel of a column begins within a row of tiles, and where the texels of a row begin, in half floats.
std::size_t offset_of_column(int x) noexcept
{
    return (std::size_t(x >> kTileBits) * kTile * kTile + std::size_t(x & (kTile - 1))) * 4;
}
std::size_t offset_of_row(int y, int tiles_x) noexcept
{
    return (std::size_t(y >> kTileBits) * std::size_t(tiles_x) * kTile + std::size_t(y & (kTile - 1))) * kTile * 4;
}

}  // namespace

MipImage::Level::Level(int width_texels, int height_texels)
    : width(width_texels),
      height(height_texels),
      tiles_x(tiles(width_texels)),
      halves(std::size_t(tiles_x) * std::size_t(tiles(height_texels)) * kTile * kTile * 4)
{
}

std::size_t MipImage::Level::offset(int x, int y) const noexcept { return offset_of_row(y, tiles_x) + offset_of_column(x); }
Vec4f MipImage::Level::texel(int x, int y) const noexcept
{
    const std::uint16_t* h = &halves[offset(x, y)];
    return {float_from_half(h[0]), float_from_half(h[1]), float_from_half(h[2]), float_from_half(h[3])};
}
void MipImage::Level::write_row(int y, std::span<const Vec4f> texels)
{
    std::vector<std::uint16_t> row(texels.size() * 4);
    finite_halves_from_floats(&texels[0].x, row.size(), row.data());
    for (int x = 0; x < width; ++x) std::copy_n(&row[static_cast<std::size_t>(x) * 4], 4, &halves[offset(x, y)]);
}
void MipImage::Level::write_column(int x, std::span<const Vec4f> texels)
{
    std::vector<std::uint16_t> column(texels.size() * 4);
    finite_halves_from_floats(&texels[0].x, column.size(), column.data());
    for (int y = 0; y < height; ++y) std::copy_n(&column[static_cast<std::size_t>(y) * 4], 4, &halves[offset(x, y)]);
}

MipImage::MipImage(int width, int height) { levels_.emplace_back(width, height); }

std::size_t MipImage::bytes() const noexcept
{
    std::size_t sum = 0;
    for (const Level& level : levels_) sum += level.halves.size() * sizeof(std::uint16_t);
    return sum;
}

std::size_t MipImage::bytes_of(int width, int height) noexcept
{
    std::size_t sum = 0;
    for (;; width = std::max(1, width / 2), height = std::max(1, height / 2)) {
        sum += std::size_t(tiles(width)) * std::size_t(tiles(height)) * kTile * kTile * 4 * sizeof(std::uint16_t);
        if (width == 1 && height == 1) return sum;
    }
}

void MipImage::write_row(int y, std::span<const Vec4f> texels)
{
    texels = texels.first(static_cast<std::size_t>(width()));
    count(texels);
    levels_[0].write_row(y, texels);
}

void MipImage::write_column(int x, std::span<const Vec4f> texels)
{
    texels = texels.first(static_cast<std::size_t>(height()));
    count(texels);
    levels_[0].write_column(x, texels);
}

void MipImage::count(std::span<const Vec4f> texels) noexcept
{
    constexpr float kLargestHalf = 65504;
    for (const Vec4f& t : texels) {
        const Vec4f size = glm::abs(t);
        clamped_texels_ += !(size.x <= kLargestHalf && size.y <= kLargestHalf && size.z <= kLargestHalf &&
                             size.w <= kLargestHalf);
        texels_below_0_ += t.x < 0 || t.y < 0 || t.z < 0;
        for (int c = 0; c < 3; ++c)
            if (t[c] > brightest_[c]) brightest_[c] = std::min(t[c], kLargestHalf);
    }
}

void MipImage::build_levels()
{
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(halved(levels_.back()));
}

MipImage::Level MipImage::halved(const Level& from)
{
    Level to(std::max(1, from.width / 2), std::max(1, from.height / 2));
    std::vector<Taps> columns;
    std::vector<Vec4f> row(static_cast<std::size_t>(to.width));
    for (int x = 0; x < to.width; ++x) columns.push_back(taps_of(x, from.width, to.width));
    for (int y = 0; y < to.height; ++y) {
        const Taps rows = taps_of(y, from.height, to.height);
        for (int x = 0; x < to.width; ++x) {
            const Taps& column = columns[static_cast<std::size_t>(x)];
            vfloat4 sum(0.0f);
            for (int j = 0; j < rows.count; ++j)
                for (int i = 0; i < column.count; ++i)
                    sum = sum + vfloat4::from_halves(from.at(column.first + i, rows.first + j)) *
                                    (rows.weight[j] * column.weight[i]);
            sum.store(&row[static_cast<std::size_t>(x)].x);
        }
        to.write_row(y, row);
    }
    return to;
}

Vec4f MipImage::lookup(int level, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest) const noexcept
{
    const Level& l = levels_[static_cast<std::size_t>(level)];
    const TexelPlaces at(l.width, l.height, st, wrap_s, wrap_t, nearest);
    if (nearest) return l.texel(at.x[0], at.y[0]);
    const std::size_t columns[2] = {offset_of_column(at.x[0]), offset_of_column(at.x[1])};
    const std::size_t rows[2] = {offset_of_row(at.y[0], l.tiles_x), offset_of_row(at.y[1], l.tiles_x)};
    return blended(at, [&](int i, int j) { return &l.halves[rows[j] + columns[i]]; });
}

}  // namespace occam
