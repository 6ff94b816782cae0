#include "io/texture/tile_cache.h"

#include <utility>

#include "base/half.h"
#include "base/hash.h"
#include "base/stopwatch.h"

namespace occam {
namespace {

constexpr std::size_t kLeastTiles = 4;  // of each part of the cache

}  // namespace

void TileCache::set_limit(std::size_t limit_bytes) noexcept
{
    most_bytes_a_part_ = limit_bytes / kParts;
    for (Part& part : parts_) part.keep_to(most_bytes_a_part_);
}

const TextureTile* TileCache::Part::find(Key key) noexcept
{
    const auto found = places.find(key);
    if (found == places.end()) return nullptr;
    slots[found->second].was_used = true;
    return &slots[found->second].tile;
}

void TileCache::Part::keep(Key key, TextureTile tile, std::size_t most_bytes)
{
    if (slots.size() == slots.capacity()) slots.reserve(2 * slots.size() + kLeastTiles);
    places.emplace(key, slots.size());
    bytes += tile.bytes();
    slots.push_back({key, true, std::move(tile)});
    keep_to(most_bytes);
}

void TileCache::Part::keep_to(std::size_t most_bytes) noexcept
{
    while (bytes > most_bytes && slots.size() > kLeastTiles) forget_one();
}

void TileCache::Part::forget_one() noexcept
{
    while (std::exchange(slots[hand].was_used, false)) hand = (hand + 1) % slots.size();
    bytes -= slots[hand].tile.bytes();
    places.erase(slots[hand].key);
    if (hand + 1 < slots.size()) {
        slots[hand] = std::move(slots.back());
        places.find(slots[hand].key)->second = hand;
    }
    slots.pop_back();
    hand = hand < slots.size() ? hand : 0;
}

template <class Use>
void TileCache::with_tile(TiledFile& file, int level, int column, int row, Use&& use)
{
    // A level has at most 256 x 256 tiles, and a file at most fifteen levels.
    const Key key = file.number() << 24 | Key(level) << 18 | Key(row) << 9 | Key(column);
    Part& part = parts_[mix_bits(key) % kParts];
    const auto use_known = [&] {
        const std::lock_guard lock(part.mutex);
        const TextureTile* const known = part.find(key);
        if (known) use(*known);
        return known != nullptr;
    };
    if (use_known()) return;
    const std::lock_guard reading(file.reading());
    if (use_known()) return;  // another thread has read it meanwhile
    const auto start = Clock::now();
    TextureTile tile = file.read(level, column, row);
    nanoseconds_ += static_cast<std::int64_t>(1e9 * seconds_since(start));
    ++tiles_read_;
    use(std::as_const(tile));
    const std::lock_guard lock(part.mutex);
    part.keep(key, std::move(tile), most_bytes_a_part_);
}

Vec4f TileCache::lookup(TiledFile& file, int level, Vec2f st, TextureUse::Wrap wrap_s, TextureUse::Wrap wrap_t, bool nearest)
{
    const TexelPlaces at(file.level_width(level), file.level_height(level), st, wrap_s, wrap_t, nearest);
    constexpr int kSide = TextureTile::kSide;
    const int columns[2] = {at.x[0] / kSide, at.x[1] / kSide}, rows[2] = {at.y[0] / kSide, at.y[1] / kSide};
    std::uint16_t halves[2][2][4];  // by row and column
    // Most often one tile holds all four texels.
    for (int j = 0; j < 2; j += 1 + (rows[0] == rows[1]))
        for (int i = 0; i < 2; i += 1 + (columns[0] == columns[1]))
            with_tile(file, level, columns[i], rows[j], [&](const TextureTile& tile) {
                for (int v = j; v < 2 && rows[v] == rows[j]; ++v)
                    for (int u = i; u < 2 && columns[u] == columns[i]; ++u)
                        std::copy_n(tile.at(at.x[u] % kSide, at.y[v] % kSide), 4, halves[v][u]);
            });
    if (!nearest) return blended(at, [&](int i, int j) { return halves[j][i]; });
    const std::uint16_t* const h = halves[0][0];
    return {float_from_half(h[0]), float_from_half(h[1]), float_from_half(h[2]), float_from_half(h[3])};
}

std::size_t TileCache::bytes() const noexcept
{
    std::size_t sum = 0;
    for (const Part& part : parts_) {
        const std::lock_guard lock(part.mutex);
        sum += part.bytes;
    }
    return sum;
}

}  // namespace occam
