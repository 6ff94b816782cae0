// A tile of a patch, diced at one level: vertices ready to be met by rays.
//
// Space    the cage's dicing frame.   Memory   in the arena of whoever dices.
#pragma once

#include <cstdint>
#include <span>

#include "lod/posed_cage.h"
#include "lod/rates.h"

namespace occam::lod {

/// Which part of which patch: `columns` x `rows` quads from (i0, j0) of the patch's lattice of 2^rates.u x 2^rates.v.
struct TileRef {
    static constexpr int kMaxSide = 16;  ///< quads along a side

    PatchRef patch;
    PatchRates rates;
    std::uint16_t i0 = 0, j0 = 0, columns = 1, rows = 1;

    float step_u() const noexcept { return std::ldexp(1.0f, -rates.u); }
    float step_v() const noexcept { return std::ldexp(1.0f, -rates.v); }
};

/// Closes the gap between a T-vertex and the straight piece of the neighbour: no area, the same bits on both sides.
/// watertightness rule 6: a and c are the vertices it is the middle of, which may lie outside the tile.
struct Closer {
    Vec3f a, middle, c;
    std::uint16_t i, j;  ///< the T-vertex in the tile's lattice
};

/// Vertices (i, j) at j * (columns + 1) + i.
struct LevelGrid {
    TileRef tile;
    float* x = nullptr;
    float* y = nullptr;
    float* z = nullptr;
    std::span<const Closer> closers;

    int width() const noexcept { return tile.columns + 1; }
    int height() const noexcept { return tile.rows + 1; }
    Vec3f vertex(int i, int j) const noexcept
    {
        const int at = j * width() + i;
        return {x[at], y[at], z[at]};
    }
};

/// What phase one gives each vertex of a tile, laid out as the vertices.
struct GridAttributes {
    Vec3f* normal = nullptr;       ///< unit, of the limit surface, outward
    Vec2f* uv[2] = {};             ///< null: the cage has no such set
};

}  // namespace occam::lod
