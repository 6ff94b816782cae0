#include "io/texture/mip_image.h"

#include <algorithm>
#include <cmath>

#include "base/half.h"
#include "base/half_lanes.h"
#include "base/simd.h"

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

// Maps a coordinate into one period of the wrap mode, in which an index fits an int.
float fold(float s, TextureUse::Wrap wrap) noexcept
{
    if (wrap == TextureUse::Wrap::Clamp) return std::clamp(s, 0.0f, 1.0f);
    return wrap == TextureUse::Wrap::Mirror ? s - 2 * std::floor(s * 0.5f) : s - std::floor(s);
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

// Wraps an index that is at most one texel outside of the period.
int wrapped(int i, int size, TextureUse::Wrap wrap) noexcept
{
    switch (wrap) {
        case TextureUse::Wrap::Clamp:
            return std::clamp(i, 0, size - 1);
        case TextureUse::Wrap::Repeat:
            return i < 0 ? i + size : i >= size ? i - size : i;
        case TextureUse::Wrap::Mirror:
            break;
    }
    if (i < 0) i = -1 - i;
    if (i >= 2 * size) i -= 2 * size;
    return i >= size ? 2 * size - 1 - i : i;
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
    constexpr float kLargestHalf = 65504;
    for (const Vec4f& t : texels) {
        const Vec4f size = glm::abs(t);
        clamped_texels_ += !(size.x <= kLargestHalf && size.y <= kLargestHalf && size.z <= kLargestHalf &&
                             size.w <= kLargestHalf);
    }
    levels_[0].write_row(y, texels);
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
    // Texel centres lie at halves.
    const float x = fold(st.x, wrap_s) * static_cast<float>(l.width) - 0.5f,
                y = fold(st.y, wrap_t) * static_cast<float>(l.height) - 0.5f;
    if (nearest)
        return l.texel(wrapped(static_cast<int>(std::floor(x + 0.5f)), l.width, wrap_s),
                       wrapped(static_cast<int>(std::floor(y + 0.5f)), l.height, wrap_t));
    const float x_floor = std::floor(x), y_floor = std::floor(y), fx = x - x_floor, fy = y - y_floor;
    const int x0 = static_cast<int>(x_floor), y0 = static_cast<int>(y_floor);
    int xs[2] = {x0, x0 + 1}, ys[2] = {y0, y0 + 1};
    if (x0 < 0 || xs[1] >= l.width)
        for (int& i : xs) i = wrapped(i, l.width, wrap_s);
    if (y0 < 0 || ys[1] >= l.height)
        for (int& i : ys) i = wrapped(i, l.height, wrap_t);
    const std::size_t columns[2] = {offset_of_column(xs[0]), offset_of_column(xs[1])};
    const std::size_t rows[2] = {offset_of_row(ys[0], l.tiles_x), offset_of_row(ys[1], l.tiles_x)};
    const auto texel_at = [&](int i, int j) { return vfloat4::from_halves(&l.halves[rows[j] + columns[i]]); };
    const vfloat4 top = texel_at(0, 0) * (1 - fx) + texel_at(1, 0) * fx;
    const vfloat4 bottom = texel_at(0, 1) * (1 - fx) + texel_at(1, 1) * fx;
    Vec4f mean;
    (top * (1 - fy) + bottom * fy).store(&mean.x);
    return mean;
}

}  // namespace occam
