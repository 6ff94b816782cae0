// A tile of a patch, diced at one level or for a pair of levels: vertices ready to be met by rays.
//
// Space    the cage's dicing frame.   Memory   in the arena of whoever dices.
#pragma once

#include <cstdint>
#include <span>

#include "base/power_of_two.h"
#include "lod/posed_cage.h"
#include "lod/rates.h"

namespace occam::lod {

/// Which part of which patch: `columns` x `rows` quads from (i0, j0) of the patch's lattice of 2^rates.u x 2^rates.v.
struct TileRef {
    static constexpr int kSideExponent = 4;
    static constexpr int kMaxSide = 1 << kSideExponent;  ///< quads along a side

    PatchRef patch;
    PatchRates rates;
    std::uint32_t i0 = 0, j0 = 0;
    std::uint16_t columns = 1, rows = 1;

    float step_u() const noexcept { return power_of_two(-rates.u); }
    float step_v() const noexcept { return power_of_two(-rates.v); }
};

/// A T-vertex: not a vertex of its own, but a point on the straight piece of a side between two edge vertices a and c, which
/// may lie outside of the tile. It is found by halving the piece `depth` times, going to the upper half where a bit of
/// `path` is set (the first halving's is the highest), and taking the middle once more. The triangle (lower end, middle,
/// upper end) of the last half has no area and closes the gap to the neighbour (watertightness rules 4 and 6).
struct Hanging {
    std::uint32_t a = 0, c = 0;  ///< vertices of the grid
    std::uint32_t path = 0;
    std::uint8_t depth = 0;
    bool is_inside = true;      ///< lies on the tile; else only its triangle reaches into it
    std::uint8_t i = 0, j = 0;  ///< in the tile's lattice; the nearest vertex, if it is not inside

    struct Ends {
        Vec3f low, middle, high;
    };
    /// Of the straight piece from a to c.
    Ends on(Vec3f low, Vec3f high) const noexcept
    {
        for (int d = depth; d > 0; --d) {
            const Vec3f m = (low + high) * 0.5f;
            (path >> (d - 1) & 1 ? low : high) = m;
        }
        return {low, (low + high) * 0.5f, high};
    }
};

/// Vertices (i, j) at j * (columns + 1) + i, then those edge vertices outside of the tile that T-vertices lie between.
struct LevelGrid {
    static constexpr int kMaxExtra = 8;

    TileRef tile;
    float* fine[3] = {};  ///< x, y, z
    float* coarse[3] =
        {};  ///< where each of them lies in the mesh of the next coarser level; the same arrays, if nowhere else
    int vertex_count = 0;
    bool is_halved = false;  ///< the next coarser level has half as many rows and columns
    std::span<const Hanging> hanging;

    int width() const noexcept { return tile.columns + 1; }
    int height() const noexcept { return tile.rows + 1; }
    int index(int i, int j) const noexcept { return j * width() + i; }
    Vec3f at(int index) const noexcept { return {fine[0][index], fine[1][index], fine[2][index]}; }
    Vec3f coarse_at(int index) const noexcept { return {coarse[0][index], coarse[1][index], coarse[2][index]}; }
    Vec3f vertex(int i, int j) const noexcept { return at(index(i, j)); }
    bool blends() const noexcept { return coarse[0] != fine[0]; }
};

/// What phase one gives each vertex of a tile, laid out as the vertices.
struct GridAttributes {
    // Behind the last of each there is room for one more: four floats may be read from any.
    Vec3f* normal = nullptr;  ///< unit, of the limit surface or of the displaced one, outward
    Vec3f* coarse_normal =
        nullptr;        ///< displaced: of the next coarser level; null: the mean of neighbours, as positions are
    Vec2f* uv[2] = {};  ///< null: the cage has no such set
};

}  // namespace occam::lod
