#include "lod/tile_dicer.h"

#include <algorithm>

namespace occam::lod {
namespace {

// Says which sides of its patch a tile touches: v = 0, u = 1, v = 1, u = 0.
struct TouchedSides {
    bool bottom, right, top, left;
    explicit TouchedSides(const TileRef& tile) noexcept
        : bottom(tile.j0 == 0),
          right(tile.i0 + tile.columns == 1u << tile.rates.u),
          top(tile.j0 + tile.rows == 1u << tile.rates.v),
          left(tile.i0 == 0)
    {
    }
};

}  // namespace

LevelGrid TileDicer::dice(const PosedCage& cage, const TileRef& tile, Arena& arena)
{
    LevelGrid grid;
    grid.tile = tile;
    grid.vertex_count = grid.width() * grid.height();
    vertices += static_cast<std::uint64_t>(grid.vertex_count);
    hanging_.clear();
    outside_.clear();
    bool hangs = false;
    for (int side = 0; side < 4; ++side) hangs |= tile.rates.side[side] != (side & 1 ? tile.rates.v : tile.rates.u);
    // One array holds all three coordinates, and eight more floats, since lanes are loaded eight at a time.
    const std::size_t room = static_cast<std::size_t>(grid.vertex_count + (hangs ? LevelGrid::kMaxExtra : 0));
    float* data = arena.make_array<float>(3 * room + 8).data();
    for (std::size_t a = 0; a < 3; ++a) grid.fine[a] = grid.coarse[a] = data + a * room;
    dice_inside(cage, grid);
    dice_sides(cage, grid);
    return grid;
}

// Dices the points that are not on the patch's borders.
void TileDicer::dice_inside(const PosedCage& cage, LevelGrid& grid)
{
    const TileRef& tile = grid.tile;
    const TouchedSides touches(tile);
    const int i0 = touches.left, i1 = grid.width() - touches.right, j0 = touches.bottom, j1 = grid.height() - touches.top;
    if (i0 >= i1 || j0 >= j1) return;
    const ParameterGrid inside{float(tile.i0 + i0) * tile.step_u(),
                               float(tile.j0 + j0) * tile.step_v(),
                               tile.step_u(),
                               tile.step_v(),
                               i1 - i0,
                               j1 - j0};
    const int at = grid.index(i0, j0);
    float* const out[3] = {grid.fine[0] + at, grid.fine[1] + at, grid.fine[2] + at};
    surface_.points({cage, tile.patch, tile.rates.filter}, inside, out, grid.width());
}

// Dices the points on the patch's borders.
void TileDicer::dice_sides(const PosedCage& cage, LevelGrid& grid)
{
    const TileRef& tile = grid.tile;
    // A side of one step consists of corners that the other sides have as well.
    const bool is_low = tile.rates.v == 0, is_narrow = tile.rates.u == 0;
    if (is_low && is_narrow && cage.topology->face_size(tile.patch.face) == 4) {
        const std::array<std::uint32_t, 4> quad = cage.topology->quad_vertices(tile.patch.face);
        constexpr int kPlace[4] = {0, 1, 3, 2};
        for (std::size_t c = 0; c < 4; ++c) {
            const Vec3f p = curves_.vertex_point(cage, quad[c], tile.rates.filter);
            for (int a = 0; a < 3; ++a) grid.fine[a][kPlace[c]] = p[a];
        }
        return;
    }
    const TouchedSides touches(tile);
    if (is_low || !is_narrow) {
        if (touches.bottom) dice_side(cage, 0, grid);
        if (touches.top) dice_side(cage, 2, grid);
    }
    if (!is_low) {
        if (touches.right) dice_side(cage, 1, grid);
        if (touches.left) dice_side(cage, 3, grid);
    }
}

void TileDicer::dice_side(const PosedCage& cage, int side, LevelGrid& grid)
{
    const TileRef& tile = grid.tile;
    const bool along_v = side & 1;
    const int exponent = along_v ? tile.rates.v : tile.rates.u;
    const int shift = exponent - tile.rates.side[side];  // 2^shift lattice steps to an edge piece
    const int first = static_cast<int>(along_v ? tile.j0 : tile.i0), count = along_v ? tile.rows : tile.columns;
    const int fixed = side == 1 ? tile.columns : side == 2 ? tile.rows : 0;

    const int piece0 = first >> shift, piece1 = (first + count + (1 << shift) - 1) >> shift;
    side_points_.resize(static_cast<std::size_t>(piece1 - piece0 + 1));
    curves_.points_of_side(cage, tile, side, piece0, side_points_);

    const auto write = [&](int at, Vec3f p) {
        for (int a = 0; a < 3; ++a) grid.fine[a][at] = p[a];
    };
    const auto lattice = [&](int n) { return along_v ? grid.index(fixed, n) : grid.index(n, fixed); };
    // Returns the vertex at lattice step `index` of the side, which ends a piece.
    const auto place_end = [&](int index, Vec3f p) {
        const int n = index - first;
        const bool is_inside = n >= 0 && n <= count;
        const int at = is_inside ? lattice(n) : grid.vertex_count++;
        if (!is_inside) outside_.push_back({side, index >> shift});
        write(at, p);
        return static_cast<std::uint32_t>(at);
    };
    // Halves a piece down to single steps. A tile closes every gap along its part of the side, so it keeps the gap triangles
    // of all halvings that reach into it, even if the T-vertex itself lies outside.
    Hanging next;
    const auto halve = [&](const auto& self, int low, int high, Vec3f a, Vec3f c, std::uint32_t path, int depth) -> void {
        if (high - low < 2 || low >= first + count || high <= first) return;
        const int mid = (low + high) / 2;
        const Vec3f p = (a + c) * 0.5f;
        const int inside = std::clamp(mid - first, 0, count);
        next.path = path;
        next.depth = static_cast<std::uint8_t>(depth);
        next.is_inside = mid == first + inside;
        next.i = static_cast<std::uint8_t>(along_v ? fixed : inside);
        next.j = static_cast<std::uint8_t>(along_v ? inside : fixed);
        if (next.is_inside) write(lattice(inside), p);
        hanging_.push_back(next);
        self(self, low, mid, a, p, path << 1, depth + 1);
        self(self, mid, high, p, c, path << 1 | 1, depth + 1);
    };
    std::uint32_t end = place_end(piece0 << shift, side_points_[0]);
    for (int piece = piece0; piece < piece1; ++piece) {
        const Vec3f a = side_points_[static_cast<std::size_t>(piece - piece0)],
                    c = side_points_[static_cast<std::size_t>(piece - piece0 + 1)];
        next.a = end;
        next.c = end = place_end((piece + 1) << shift, c);
        halve(halve, piece << shift, (piece + 1) << shift, a, c, 0, 0);
    }
}

}  // namespace occam::lod
