#include "lod/displaced_patches.h"

#include <array>
#include <cmath>

#include "base/check.h"
#include "base/cross_product.h"
#include "lod/level_grid.h"

namespace occam::lod {

void DisplacedPatches::offsets(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride)
{
    const PosedDisplacement& displacement = of.cage.displacement;
    const int columns = grid.columns, count = columns * grid.rows;
    const bool turns = displacement.turns;
    const int arrays = turns ? 27 : 21;
    surface_.resize(static_cast<std::size_t>(arrays * count));
    float* at[27] = {};
    for (int a = 0; a < arrays; ++a) at[a] = &surface_[static_cast<std::size_t>(a * count)];
    pool_.posed(of.cage, of.patch).points_and_tangents(grid, at, columns);
    pool_.displaced_uv(of.cage, of.patch).points_and_tangents(grid, at + 9, columns);
    if (turns) pool_.rest(of.cage, of.patch).points_and_tangents(grid, at + 18, columns);
    if (displacement.of->space == Displacement::Space::Normal) {
        const PointsToDisplace all{{at[3], at[4], at[5]}, {at[6], at[7], at[8]}, {at[9], at[10]},
                                   {at[12], at[13]},      {at[15], at[16]},      count};
        displacement.offsets_along_normal(all, of.filter, at + 18);
        for (int a = 0; a < 3; ++a)
            for (int j = 0; j < grid.rows; ++j) std::copy_n(at[18 + a] + j * columns, columns, out[a] + j * stride);
        return;
    }
    const auto pair = [&](int from, int k) { return Vec2f(at[from][k], at[from + 1][k]); };
    const auto triple = [&](int from, int k) { return Vec3f(at[from][k], at[from + 1][k], at[from + 2][k]); };
    for (int j = 0; j < grid.rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const int k = j * columns + i;
            PointToDisplace point{triple(3, k), triple(6, k), pair(9, k), pair(12, k), pair(15, k)};
            if (turns) point.rest_du = triple(21, k), point.rest_dv = triple(24, k);
            const Vec3f moved = displacement.offset(point, of.filter);
            for (int a = 0; a < 3; ++a) out[a][j * stride + i] = moved[a];
        }
}

void DisplacedPatches::points(const FilteredPatch& of, const ParameterGrid& grid, float* const out[3], int stride)
{
    offsets(of, grid, out, stride);
    for (int a = 0; a < 3; ++a)
        for (int j = 0; j < grid.rows; ++j)
            for (int i = 0; i < grid.columns; ++i)
                out[a][j * stride + i] += surface_[static_cast<std::size_t>((a * grid.rows + j) * grid.columns + i)];
}

void DisplacedPatches::curve(const FilteredPatch& of, const ParameterLine& line, std::span<Vec3f> out)
{
    // Grids run with rising parameters; a point's bits do not depend on those beside it.
    const auto count = static_cast<int>(out.size());
    const float low = line.step < 0 ? line.t0 + float(count - 1) * line.step : line.t0, step = std::fabs(line.step);
    const ParameterGrid grid = line.along_v ? ParameterGrid{line.fixed, low, 1, step, 1, count}
                                            : ParameterGrid{low, line.fixed, step, 1, count, 1};
    std::array<float, 3 * (TileRef::kMaxSide + 1)> found;
    OCCAM_DCHECK_LE(count, TileRef::kMaxSide + 1);
    float* const to[3] = {&found[0], &found[TileRef::kMaxSide + 1], &found[2 * (TileRef::kMaxSide + 1)]};
    points(of, grid, to, line.along_v ? 1 : count);
    for (int i = 0; i < count; ++i) {
        const int k = line.step < 0 ? count - 1 - i : i;
        out[static_cast<std::size_t>(i)] = {to[0][k], to[1][k], to[2][k]};
    }
}

void DisplacedPatches::offsets_beside(const FilteredPatch& of, const ParameterGrid& grid, int axis, float by,
                                      float* const out[3])
{
    const int lines = axis == 0 ? grid.columns : grid.rows, stride = axis == 0 ? 1 : grid.columns;
    const float first = axis == 0 ? grid.u0 : grid.v0, step = axis == 0 ? grid.step_u : grid.step_v;
    const auto part = [&](int from, int count, float moved) {
        if (count == 0) return;
        ParameterGrid piece = grid;
        (axis == 0 ? piece.columns : piece.rows) = count;
        (axis == 0 ? piece.u0 : piece.v0) = first + float(from) * step + moved;
        float* const to[3] = {out[0] + from * stride, out[1] + from * stride, out[2] + from * stride};
        offsets(of, piece, to, grid.columns);
    };
    const int stay_low = by < 0 && first == 0, stay_high = by > 0 && first + float(lines - 1) * step == 1;
    part(0, stay_low, 0);
    part(stay_low, lines - stay_low - stay_high, by);
    part(lines - stay_high, stay_high, 0);
}

// Computes normals from the derivative of P + h N: the tangents of the limit surface, plus differences of the offset over a
// quarter step to each side (to one side on the patch's border). Over smooth edges the normals of both patches agree except
// for a difference of the second order in the step; at creases and seams each patch has its own.
void DisplacedPatches::normals(const FilteredPatch& of, const ParameterGrid& grid, Vec3f* out)
{
    const auto count = static_cast<std::size_t>(grid.columns * grid.rows);
    beside_.resize(15 * count);
    float* at[15];
    for (std::size_t a = 0; a < 15; ++a) at[a] = &beside_[a * count];
    const float quarter[2] = {grid.step_u / 4, grid.step_v / 4};
    for (int axis : {0, 1}) {
        offsets_beside(of, grid, axis, -quarter[axis], at);
        offsets_beside(of, grid, axis, quarter[axis], at + 3);
        for (int j = 0; j < grid.rows; ++j)
            for (int i = 0; i < grid.columns; ++i) {
                const float t = axis == 0 ? grid.u0 + float(i) * grid.step_u : grid.v0 + float(j) * grid.step_v;
                const float width = (t == 0 || t == 1 ? 1.0f : 2.0f) * quarter[axis];
                const auto k = static_cast<std::size_t>(j * grid.columns + i);
                for (int a = 0; a < 3; ++a) at[9 + 3 * axis + a][k] = (at[3 + a][k] - at[a][k]) / width;
            }
    }
    offsets(of, grid, at, grid.columns);
    for (std::size_t k = 0; k < count; ++k) {
        const auto tangent = [&](std::size_t axis) {
            Vec3f t;
            for (std::size_t a = 0; a < 3; ++a)
                t[static_cast<int>(a)] = surface_[(3 + 3 * axis + a) * count + k] + at[9 + 3 * axis + a][k];
            return t;
        };
        out[k] = unit_normal(tangent(0), tangent(1), of.cage.displacement.sense);
    }
}

// The first rows are measured alone. Where a patch is so steep that both speeds reach their most there, which a sixth of the
// points then tells, the rest is not measured.
void DisplacedPatches::raise_speeds(const PosedCage& cage, PatchRef patch, float& along_u, float& along_v)
{
    constexpr int kMostWidth = kSpeedPieces + 1, kFirstRows = 3;
    // A patch of an n-gon has half of the sides of its face, and half of the pieces.
    const int halves = cage.topology->face_size(patch.face) == 4 ? 0 : 1, pieces = kSpeedPieces >> halves,
              width = pieces + 1;
    std::array<float, 3 * kMostWidth * kMostWidth> found;
    float* const at[3] = {&found[0], &found[kMostWidth * kMostWidth], &found[2 * kMostWidth * kMostWidth]};
    const float step = power_of_two(halves) / kSpeedPieces;
    const int filter = level_of_pieces(std::max(along_u, along_v) * power_of_two(halves));
    const auto distance = [&](int a, int b) {
        return glm::length(Vec3f(at[0][a] - at[0][b], at[1][a] - at[1][b], at[2][a] - at[2][b]));
    };
    const float most_u = most_speed(along_u), most_v = most_speed(along_v);
    float longest_u = 0, longest_v = 0;
    for (int done = 0; done < width;) {
        const int rows = done == 0 ? kFirstRows : width - done, first = done * width;
        float* const to[3] = {at[0] + first, at[1] + first, at[2] + first};
        points({cage, patch, filter}, {0, float(done) * step, step, step, width, rows}, to, width);
        for (int j = done; j < done + rows; ++j)
            for (int i = 0; i < width; ++i) {
                const int k = j * width + i;
                if (i > 0) longest_u = std::max(longest_u, distance(k - 1, k));
                if (j > 0) longest_v = std::max(longest_v, distance(k - width, k));
            }
        done += rows;
        if (float(pieces) * longest_u >= most_u && float(pieces) * longest_v >= most_v) break;
    }
    along_u = diced_speed(float(pieces) * longest_u, along_u);
    along_v = diced_speed(float(pieces) * longest_v, along_v);
}

}  // namespace occam::lod
