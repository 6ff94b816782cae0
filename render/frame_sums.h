// The sums of all pixels of a frame that is made in rounds, from which a stopped frame can continue.
//
// A tile's pixels lie together, in the order of pixels_of(), and each pixel holds only the sums that the requested layers
// need. A checkpoint is all of this as bytes. It holds sums in double and whole samples, so a frame that continues from it
// has the same bits as one that was never stopped.
//
// Memory   64 to 200 bytes a pixel, and up to 1 KB more for each Cryptomatte layer, beside the budget. Each tile takes what
//          a whole one does, so the sides of the picture count as if they were rounded up to multiples of kTileSide.
// Threads  each tile is read and written by one worker at a time.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/cryptomatte.h"
#include "render/film.h"
#include "render/tiles.h"

namespace occam::render {

/// The layers of mattes, in the order in which their sums are kept.
inline constexpr Aov kMattes[] = {Aov::CryptomatteObject, Aov::CryptomatteMaterial};

/// How the Errors of FrameSums::restore() begin.
inline constexpr std::string_view kTheCheckpoint = "the checkpoint ";

class FrameSums {
public:
    FrameSums(const Settings& settings, const Camera& camera);
    static std::size_t bytes_for(const Settings& settings) noexcept;

    /// Says how far a tile is.
    /// samples   of the pixels that go on; Settings::error may have ended others, which have fewer
    /// is_done   no pixel goes on
    struct Tile {
        std::int32_t samples = 0, is_done = 0;
    };
    Tile tile(const PixelRect& rect) const noexcept { return tiles_[index_of(rect)]; }
    /// Appends one entry for each pixel to the arrays. Those of Cryptomatte layers that were not requested stay empty.
    void load(const PixelRect& rect, std::vector<PixelSums>& sums, std::vector<MatteSums> (&mattes)[2]) const;
    /// Stores the sums of a tile.
    /// first   index of the tile's first pixel in the arrays
    void store(const PixelRect& rect, Tile tile, std::span<const PixelSums> sums, const std::vector<MatteSums> (&mattes)[2],
               std::size_t first);

    int least_samples() const noexcept;  ///< the smallest number of samples of any tile
    /// scene_hash   content_hash() of the scene, or content_and_slots_hash() where the picture shows slots
    std::string checkpoint(std::uint64_t scene_hash) const;
    /// Continues from a checkpoint. Throws Error if it is not a checkpoint of this frame.
    void restore(std::string_view checkpoint, std::uint64_t scene_hash);

private:
    std::size_t index_of(const PixelRect& rect) const noexcept;
    std::size_t first_pixel(std::size_t tile) const noexcept { return tile * std::size_t(kTileSide * kTileSide); }

    AovSet aovs_;
    PixelRect area_;
    std::size_t columns_;
    int spp_;
    std::uint64_t identity_;  ///< hash of the settings and the camera
    std::size_t stride_;      ///< bytes of a pixel's sums
    std::vector<Tile> tiles_;
    std::vector<std::byte> sums_;
    std::vector<MatteSums> mattes_[2];
};

}  // namespace occam::render
