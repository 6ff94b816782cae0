// Tiles of texture files, read when a lookup first needs them and forgotten when others need the room.
//
// Which tiles are in memory has no influence on a texel.
//
// Memory   32 KB a tile of full size: the limit at most, or four tiles in each of 16 parts if that is more. Each thread
//          has one tile more while it reads.
// Threads  any number of threads may look up. A lookup takes the lock of one of 16 parts of the cache, and no lock of the
//          cache is held while a tile is read.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "io/texture/texel_places.h"
#include "io/texture/tiled_file.h"

namespace occam {

class TileCache {
public:
    explicit TileCache(std::size_t limit_bytes) { set_limit(limit_bytes); }
    /// Forgets tiles if there are too many now. No other thread looks up meanwhile.
    void set_limit(std::size_t limit_bytes) noexcept;

    /// Returns the bilinear or the nearest texel about `st` of a level, with the bits of MipImage::lookup(). Throws what
    /// TiledFile::read() throws, and std::bad_alloc.
    Vec4f lookup(TiledFile& file, int level, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest);

    std::size_t bytes() const noexcept;
    /// Returns the seconds that threads have spent on reading tiles, summed.
    double read_seconds() const noexcept { return 1e-9 * static_cast<double>(nanoseconds_.load()); }
    std::uint64_t tiles_read() const noexcept { return tiles_read_; }

private:
    using Key = std::uint64_t;
    struct Slot {
        Key key = 0;
        bool was_used = false;  ///< since the hand last passed
        TextureTile tile;
    };
    /// Holds a part of the tiles. The one that gives way is found by a hand that goes round and spares those that were used
    /// since it last passed (CLOCK, an approximation of the least recently used one).
    struct Part {
        mutable std::mutex mutex;
        std::unordered_map<Key, std::size_t> places;
        std::vector<Slot> slots;
        std::size_t hand = 0, bytes = 0;

        const TextureTile* find(Key key) noexcept;
        void keep(Key key, TextureTile tile, std::size_t most_bytes);
        void keep_to(std::size_t most_bytes) noexcept;
        void forget_one() noexcept;
    };
    static constexpr std::size_t kParts = 16;

    /// Calls `use` with a tile while it cannot give way.
    template <class Use>
    void with_tile(TiledFile& file, int level, int column, int row, Use&& use);

    std::size_t most_bytes_a_part_ = 0;
    std::array<Part, kParts> parts_;
    std::atomic<std::int64_t> nanoseconds_ = 0;
    std::atomic<std::uint64_t> tiles_read_ = 0;
};

}  // namespace occam
