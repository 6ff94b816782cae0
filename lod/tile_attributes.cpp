#include "lod/tile_attributes.h"

#include <algorithm>

namespace occam::lod {
namespace {

// Returns the parameters of every step-th vertex of a tile.
ParameterGrid parameters_of(const TileRef& tile, int step)
{
    return {float(tile.i0) * tile.step_u(), float(tile.j0) * tile.step_v(), float(step) * tile.step_u(),
            float(step) * tile.step_v(),    tile.columns / step + 1,        tile.rows / step + 1};
}

}  // namespace

GridAttributes TileAttributes::make(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Arena& arena)
{
    const ParameterGrid grid = parameters_of(tile, 1);
    const auto count = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
    const auto keys = static_cast<std::size_t>(cage.segments) + 1;
    vertices += count * keys;

    GridAttributes made;
    const bool has_coarse = cage.is_displaced() && coarser != tile.rates;
    made.normals_of_a_key = has_coarse ? 2 * count : count;
    made.normal = arena.make_array<Vec3f>(keys * made.normals_of_a_key + 1).data();
    if (has_coarse) made.coarse_normal = made.normal + count;
    for (std::size_t k = 0; k < keys; ++k) {
        const PosedCage& at = cage.at_key(static_cast<int>(k));
        surface_.normals({at, tile.patch, tile.rates.filter}, grid, made.normal + k * made.normals_of_a_key);
        if (has_coarse) coarse_normals(at, tile, coarser, made.coarse_normal + k * made.normals_of_a_key);
    }
    uvs_.resize(3 * count);
    for (int set = 0; set < std::min(2, cage.topology->uv_set_count()); ++set) {
        made.uv[set] = arena.make_array<Vec2f>(count + 1).data();
        surface_.uv(cage, tile.patch, set).points(grid, &uvs_[0], &uvs_[count], &uvs_[2 * count], grid.columns);
        for (std::size_t k = 0; k < count; ++k) made.uv[set][k] = {uvs_[k], uvs_[count + k]};
    }
    return made;
}

void TileAttributes::coarse_normals(const PosedCage& cage, const TileRef& tile, const PatchRates& coarser, Vec3f* out)
{
    const int step = coarser.u != tile.rates.u ? 2 : 1;
    const ParameterGrid grid = parameters_of(tile, step);
    normals_.resize(static_cast<std::size_t>(grid.columns * grid.rows));
    surface_.normals({cage, tile.patch, coarser.filter}, grid, normals_.data());
    const auto normal = [&](int i, int j) { return normals_[static_cast<std::size_t>(j * grid.columns + i)]; };
    for (int j = 0; j <= tile.rows; ++j)
        for (int i = 0; i <= tile.columns; ++i)
            *out++ = step == 1 ? normal(i, j) : (normal(i / 2, j / 2) + normal((i + 1) / 2, (j + 1) / 2)) * 0.5f;
}

}  // namespace occam::lod
