#include "render/tiles.h"

#include <algorithm>
#include <bit>

namespace occam::render {
namespace {

struct Cell {
    unsigned x, y;
};

// Returns the cell at distance d along a Hilbert curve over a square of `side` cells, a power of two. It goes quadrant by
// quadrant from the smallest up, each turned so that its ends meet its neighbours' (Skilling 2004 gives the general
// form).
Cell hilbert_cell(unsigned side, std::uint64_t d)
{
    Cell c{0, 0};
    for (unsigned s = 1; s < side; s *= 2, d /= 4) {
        const unsigned right = (d / 2) & 1, up = (d ^ right) & 1;
        if (!up) {
            if (right) c = {s - 1 - c.x, s - 1 - c.y};
            std::swap(c.x, c.y);
        }
        c.x += s * right;
        c.y += s * up;
    }
    return c;
}

}  // namespace

std::vector<PixelRect> make_tiles(PixelRect area)
{
    const auto columns = static_cast<unsigned>((area.width() + kTileSide - 1) / kTileSide);
    const auto rows = static_cast<unsigned>((area.height() + kTileSide - 1) / kTileSide);
    const unsigned side = std::bit_ceil(std::max(columns, rows));
    std::vector<PixelRect> tiles;
    tiles.reserve(std::size_t(columns) * rows);
    for (std::uint64_t d = 0; d < std::uint64_t(side) * side; ++d) {
        const Cell c = hilbert_cell(side, d);
        if (c.x >= columns || c.y >= rows) continue;
        const int x = area.x0 + static_cast<int>(c.x) * kTileSide, y = area.y0 + static_cast<int>(c.y) * kTileSide;
        tiles.push_back({x, y, std::min(x + kTileSide, area.x1), std::min(y + kTileSide, area.y1)});
    }
    return tiles;
}

std::vector<Pixel> pixels_of(const PixelRect& tile)
{
    const auto every_other = [](unsigned bits) {
        unsigned packed = 0;
        for (unsigned b = 0; bits >> (2 * b) != 0; ++b) packed |= (bits >> (2 * b) & 1) << b;
        return static_cast<int>(packed);
    };
    const unsigned side = std::bit_ceil(static_cast<unsigned>(std::max(tile.width(), tile.height())));
    std::vector<Pixel> pixels;
    for (unsigned d = 0; d < side * side; ++d) {
        const Pixel p{tile.x0 + every_other(d), tile.y0 + every_other(d >> 1)};
        if (p.x < tile.x1 && p.y < tile.y1) pixels.push_back(p);
    }
    return pixels;
}

TileQueue::TileQueue(std::vector<PixelRect> tiles, int workers) : tiles_(std::move(tiles))
{
    const auto n = static_cast<std::size_t>(workers);
    for (std::size_t w = 0; w < n; ++w) stretches_.push_back({tiles_.size() * w / n, tiles_.size() * (w + 1) / n});
}

std::optional<PixelRect> TileQueue::next(int worker)
{
    const std::lock_guard lock(mutex_);
    Stretch& own = stretches_[static_cast<std::size_t>(worker)];
    if (own.length() == 0) {
        Stretch& longest = *std::max_element(stretches_.begin(), stretches_.end(),
                                             [](const Stretch& a, const Stretch& b) { return a.length() < b.length(); });
        if (longest.length() == 0) return std::nullopt;
        const std::size_t middle = longest.first + longest.length() / 2;
        own = {middle, longest.last};
        longest.last = middle;
    }
    return tiles_[own.first++];
}

}  // namespace occam::render
