// A tile of a patch, diced at one level or for a pair of levels: vertices that are ready to be intersected.
//
// Space    the cage's dicing frame.
// Memory   in the caller's arena.
#pragma once

#include <cstdint>
#include <span>

#include "base/power_of_two.h"
#include "lod/posed_cage.h"
#include "lod/rates.h"
#include "lod/short_normal.h"

namespace occam::lod {

/// Part of a patch: `columns` x `rows` quads from (i0, j0) of the patch's lattice of 2^rates.u x 2^rates.v.
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

/// A T-vertex: it is not a vertex of its own, but a point on the straight piece of a side between two edge vertices a and c,
/// which may lie outside the tile. It is found by halving the piece `depth` times, taking the upper half where a bit of
/// `path` is set (the highest bit belongs to the first halving), and taking the middle once more. The gap triangle (lower
/// end, middle, upper end) of the last half has no area and closes the gap to the neighbour (watertightness rules 4 and 6).
struct Hanging {
    std::uint32_t a = 0, c = 0;  ///< indices of vertices of the grid
    std::uint32_t path = 0;
    std::uint8_t depth = 0;
    bool is_inside = true;      ///< lies on the tile; otherwise only its gap triangle reaches into it
    std::uint8_t i = 0, j = 0;  ///< place in the tile's lattice; if it is not inside, the nearest vertex

    struct Ends {
        Vec3f low, middle, high;
    };
    /// Returns the ends of the last half, for the straight piece from a to c.
    Ends on(Vec3f low, Vec3f high) const noexcept
    {
        for (int d = depth; d > 0; --d) {
            const Vec3f m = (low + high) * 0.5f;
            (path >> (d - 1) & 1 ? low : high) = m;
        }
        return {low, (low + high) * 0.5f, high};
    }
};

/// Vertex (i, j) is at j * (columns + 1) + i; then come the edge vertices outside the tile between which T-vertices lie.
struct LevelGrid {
    static constexpr int kMaxExtra = 8;

    TileRef tile;
    float* fine[3] = {};    ///< x, y, z
    float* coarse[3] = {};  ///< positions in the mesh of the next coarser level; the same arrays if they do not differ
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

/// The results of phase one at each vertex of a tile, in the order of the vertices.
struct GridAttributes {
    // Each array of floats has room for one more element at its end, because four floats may be read from any element.
    Vec3f* normal = nullptr;             ///< unit, of the limit surface or of the displaced one, outward
    ShortNormal* at_keys = nullptr;      ///< the same at each key, one after the other, if the cage moves; else null
    Vec2f* uv[2] = {};                   ///< null: the cage has no such set
    std::uint32_t normals_of_a_key = 0;  ///< from a normal to the same one at the next key
    /// The distance from a normal to the same one in the next coarser level, for displaced cages. If 0, those are means of
    /// neighbours, as positions are.
    std::uint32_t to_coarse = 0;
    /// Whether the tile is flat and part of a face that is not convex. Some patches of such a face reach beyond its border
    /// or are turned over, and others cover what is behind the border in turn.
    bool overlaps_in_plane = false;
};

}  // namespace occam::lod
