#include "accel/grid_hit.h"

#include <tuple>

namespace occam::accel {
namespace {

// Identifies the micropolygon's place in its cage, whichever igrid holds it.
auto order_of(const IGrid& grid, std::uint32_t id) noexcept
{
    const std::uint32_t number = number_of(grid, id);
    if (!grid.is_lattice) return std::tuple(number, 0u, 0, 0u, 0u, 0u);
    const lod::TileRef& tile = grid.lattice().parts[part_of(number)].tile;
    const QuadRef quad = quad_of(number);
    const std::uint32_t patch_face = tile.patch.face, kind = is_gap(id) ? 2u : quad.triangle;
    return std::tuple(patch_face, tile.patch.sub, grid.pairs.finest, tile.j0 + quad.j, tile.i0 + quad.i, kind);
}

}  // namespace

bool comes_before(const IGrid& a, std::uint32_t a_id, const IGrid& b, std::uint32_t b_id) noexcept
{
    if (a.cage != b.cage)
        if (const auto order = a.cage->path <=> b.cage->path; order != 0) return order < 0;
    return order_of(a, a_id) < order_of(b, b_id);
}

}  // namespace occam::accel
