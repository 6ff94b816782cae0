// The tiles of a picture, and who makes which.
//
// Tiles follow a Hilbert curve, and each worker starts with a stretch of its own: neighbouring tiles need the same trees,
// and trees are not shared. A worker that has finished takes the later half of the longest stretch that is left.
//
// Threads  TileQueue: any thread; one short lock a tile.
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

/// Tiles that cover `area`, along a Hilbert curve.
std::vector<PixelRect> make_tiles(PixelRect area);

/// The pixels of a tile along a Morton curve: eight in a row, from a multiple of eight on, are a block of 4 x 2, whose rays
/// travel together.
std::vector<Pixel> pixels_of(const PixelRect& tile);

class TileQueue {
public:
    TileQueue(std::vector<PixelRect> tiles, int workers);

    /// The next tile of this worker; none when all are given out.
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
