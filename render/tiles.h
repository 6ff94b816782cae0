// The tiles of a picture, and their distribution to workers.
//
// Tiles follow a Hilbert curve, and each worker starts with its own part of the curve, because neighbouring tiles need the
// same parts of a tree, and usually each worker has its own tree. A worker that has finished takes the later half of the
// longest part that is left.
//
// Threads  TileQueue: any thread; it takes one short lock per tile.
#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "render/settings.h"

namespace occam::render {

inline constexpr int kTileSide = 16;

struct Pixel {
    int x, y;
};

/// Returns the tiles that cover `area`, along a Hilbert curve.
std::vector<PixelRect> make_tiles(PixelRect area);

/// Returns the pixels of a tile along a Morton curve. In a whole tile, eight in a row, starting from a multiple of eight,
/// are a block of 4 x 2, whose rays travel together. In a tile that the border of the picture cuts they may be others.
std::vector<Pixel> pixels_of(const PixelRect& tile);

class TileQueue {
public:
    TileQueue(std::vector<PixelRect> tiles, int workers);

    /// Returns the next tile of this worker, or none when all are handed out.
    std::optional<PixelRect> next(int worker);
    std::size_t size() const noexcept { return tiles_.size(); }

private:
    struct Stretch {
        std::size_t first, last;
        std::size_t length() const noexcept { return last - first; }
    };
    std::vector<PixelRect> tiles_;
    std::vector<Stretch> stretches_;
    std::mutex mutex_;
};

}  // namespace occam::render
