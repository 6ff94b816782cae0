#include "lod/dicer.h"

#include <algorithm>

namespace occam::lod {
namespace {

// Returns the tile of the next coarser level that covers the same part of the patch.
TileRef coarse_tile_of(const TileRef& tile, const PatchRates& coarser, bool is_halved)
{
    TileRef coarse = tile;
    coarse.rates = coarser;
    if (is_halved) {
        coarse.i0 /= 2;
        coarse.j0 /= 2;
        coarse.columns /= 2;
        coarse.rows /= 2;
    }
    return coarse;
}

}  // namespace

void Dicer::forget() noexcept
{
    surface_.forget();
    curves_.forget();
}

void Dicer::ask_for(const PosedCage& cage, PatchRef patch) { cage.topology->controls(patch).kind->hull().ask_for_first(); }

TileRef Dicer::tile(PatchRef patch, const PatchScale& scale, int level, std::uint32_t i, std::uint32_t j)
{
    TileRef tile{patch, scale.rates(level), i & ~(TileRef::kMaxSide - 1u), j & ~(TileRef::kMaxSide - 1u), 1, 1};
    tile.columns = static_cast<std::uint16_t>(1 << std::min(tile.rates.u, TileRef::kSideExponent));
    tile.rows = static_cast<std::uint16_t>(1 << std::min(tile.rates.v, TileRef::kSideExponent));
    return tile;
}

LevelGrid Dicer::dice(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    LevelGrid grid = tiles_.dice(cage, tile, arena);
    if (const std::span<const Hanging> hanging = tiles_.hanging(); !hanging.empty()) {
        const std::span<Hanging> kept = arena.make_array<Hanging>(hanging.size());
        std::copy(hanging.begin(), hanging.end(), kept.begin());
        grid.hanging = kept;
    }
    return grid;
}

LevelGrid Dicer::dice_pair(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena)
{
    LevelGrid grid = dice(cage, tile, arena);
    if (coarser == tile.rates) return grid;
    const std::vector<TileDicer::OutsideVertex> outside = tiles_.outside();
    const auto room = static_cast<std::size_t>(grid.vertex_count);
    float* data = arena.make_array<float>(3 * room + 8).data();
    for (std::size_t a = 0; a < 3; ++a) grid.coarse[a] = data + a * room;
    const auto write = [&](int at, Vec3f p) {
        for (int a = 0; a < 3; ++a) grid.coarse[a][at] = p[a];
    };

    const bool is_halved = grid.is_halved = coarser.u != tile.rates.u || coarser.v != tile.rates.v;
    const TileRef coarse_tile = coarse_tile_of(tile, coarser, is_halved);
    coarse_.reset();
    const LevelGrid below = tiles_.dice(cage, coarse_tile, coarse_);
    for (int j = 0; j <= tile.rows; ++j)
        for (int i = 0; i <= tile.columns; ++i) {
            const int at = grid.index(i, j);
            if (!is_halved) {
                write(at, below.vertex(i, j));
                continue;
            }
            // Odd vertices lie on an edge of the coarse mesh, or on its diagonal.
            const Vec3f low = below.vertex(i / 2, j / 2);
            write(at, (i | j) & 1 ? (low + below.vertex((i + 1) / 2, (j + 1) / 2)) * 0.5f : low);
        }
    for (std::size_t e = 0; e < outside.size(); ++e) {
        const int at = grid.width() * grid.height() + static_cast<int>(e);
        write(at, coarse_outside(cage, coarse_tile, tile.rates, outside[e], grid.at(at)));
    }
    return grid;
}

Vec3f Dicer::coarse_outside(const PosedCage& cage, const TileRef& coarse_tile, const PatchRates& rates,
                            const TileDicer::OutsideVertex& vertex, Vec3f fine)
{
    const auto side = static_cast<std::size_t>(vertex.side);
    const bool side_halves = coarse_tile.rates.side[side] != rates.side[side];
    Vec3f around[2] = {fine};
    if (side_halves && (vertex.piece & 1)) {
        curves_.points_of_side(cage, coarse_tile, vertex.side, vertex.piece / 2, around);
        return (around[0] + around[1]) * 0.5f;
    }
    // An even vertex, and one of a side that stays, is also one of the coarser level; only displacement moves it.
    if (cage.is_displaced())
        curves_.points_of_side(cage, coarse_tile, vertex.side, side_halves ? vertex.piece / 2 : vertex.piece, {around, 1});
    return around[0];
}

}  // namespace occam::lod
