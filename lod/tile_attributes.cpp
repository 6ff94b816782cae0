#include "lod/tile_attributes.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

namespace occam::lod {
namespace {

// Returns the parameters of every step-th vertex of a tile.
ParameterGrid parameters_of(const TileRef& tile, int step)
{
    return {float(tile.i0) * tile.step_u(), float(tile.j0) * tile.step_v(), float(step) * tile.step_u(),
            float(step) * tile.step_v(),    tile.columns / step + 1,        tile.rows / step + 1};
}

// Returns whether a face is not convex at some corner. Faces of very many corners are not looked at: each of their patches
// would take as long as there are corners.
bool is_concave(const PosedCage& cage, std::uint32_t face)
{
    constexpr std::uint32_t kMostCorners = 1024;
    const std::uint32_t count = cage.topology->face_size(face), first = cage.topology->first_corner(face);
    if (count < 4 || count > kMostCorners) return false;
    const auto corner = [&](std::uint32_t k) { return cage.vertex(cage.slot->cage.face_vertices[first + k % count]); };
    const auto edge = [&](std::uint32_t from, std::uint32_t to) { return Vec3d(corner(to) - corner(from)); };
    Vec3d area(0);
    for (std::uint32_t k = 1; k + 1 < count; ++k) area += glm::cross(edge(0, k), edge(0, k + 1));
    constexpr double kLeastSine = 1e-3;
    const double least = -kLeastSine * glm::length(area);
    for (std::uint32_t k = 0; k < count; ++k) {
        const Vec3d in = edge(k, k + 1), out = edge(k + 1, k + 2);
        if (glm::dot(glm::cross(in, out), area) < least * glm::length(in) * glm::length(out)) return true;
    }
    return false;
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
    if (has_coarse) made.to_coarse = static_cast<std::uint32_t>(count);
    made.normals_of_a_key = static_cast<std::uint32_t>(count) + made.to_coarse;
    const auto make_normals = [&](const PosedCage& at, Vec3f* out) {
        surface_.normals({at, tile.patch, tile.rates.filter}, grid, out);
        if (has_coarse) coarse_normals(at, tile, coarser, out + made.to_coarse);
    };
    if (cage.segments == 0) {
        made.normal = arena.make_array<Vec3f>(made.normals_of_a_key + 1).data();
        make_normals(cage, made.normal);
    } else {
        at_key_.resize(made.normals_of_a_key);
        made.at_keys = arena.make_array<ShortNormal>(keys * made.normals_of_a_key).data();
        for (std::size_t k = 0; k < keys; ++k) {
            make_normals(cage.at_key(static_cast<int>(k)), at_key_.data());
            for (std::size_t n = 0; n < at_key_.size(); ++n) made.at_keys[k * at_key_.size() + n] = ShortNormal(at_key_[n]);
        }
    }
    made.overlaps_in_plane = overlaps_in_plane(cage, tile);
    uvs_.resize(3 * count);
    for (int set = 0; set < std::min(2, cage.topology->uv_set_count()); ++set) {
        made.uv[set] = arena.make_array<Vec2f>(count + 1).data();
        surface_.uv(cage, tile.patch, set).points(grid, &uvs_[0], &uvs_[count], &uvs_[2 * count], grid.columns);
        for (std::size_t k = 0; k < count; ++k) made.uv[set][k] = {uvs_[k], uvs_[count + k]};
    }
    return made;
}

bool TileAttributes::overlaps_in_plane(const PosedCage& cage, const TileRef& tile)
{
    for (int k = 0; k <= cage.segments; ++k) {
        const PosedCage& at = cage.at_key(k);
        if (at.is_displaced() || !is_concave(at, tile.patch.face) || !is_flat(at, tile)) return false;
    }
    return true;
}

// Returns whether all points of a tile are in the plane of the first one and its diagonals, as far as rounding lets them.
bool TileAttributes::is_flat(const PosedCage& cage, const TileRef& tile)
{
    const ParameterGrid grid = parameters_of(tile, 1);
    const auto count = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
    points_.resize(3 * count);
    surface_.posed(cage, tile.patch).points(grid, &points_[0], &points_[count], &points_[2 * count], grid.columns);
    const auto at = [&](std::size_t k) { return Vec3d(points_[k], points_[count + k], points_[2 * count + k]); };
    const auto last_of_row = static_cast<std::size_t>(grid.columns) - 1;
    const Vec3d across = glm::cross(at(count - 1) - at(0), at(count - 1 - last_of_row) - at(last_of_row));
    const double length = glm::length(across), most = 16 * FLT_EPSILON * double(cage.radius);
    for (std::size_t k = 0; k < count; ++k)
        if (!(std::fabs(glm::dot(at(k) - at(0), across)) <= most * length)) return false;
    return true;
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
