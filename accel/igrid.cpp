#include "accel/igrid.h"

namespace occam::accel {

IGridPart::IGridPart(const lod::LevelGrid& vertices, int filter_of_coarse, std::uint32_t first_vertex) noexcept
    : tile(vertices.tile),
      is_transposed(tile.rows > tile.columns),
      is_halved(vertices.is_halved),
      coarse_filter(static_cast<std::int8_t>(filter_of_coarse)),
      first(first_vertex),
      width(static_cast<std::uint32_t>(fast() + 1))
{
}

IGrid::IGrid(const GridSubject& of, const Common& common, bool of_patches, bool has_two_levels, std::size_t hanging) noexcept
    : is_lattice(of_patches),
      is_hidden(of.cage.seen_by != RayKind::All || of.cage.visible_in != lod::PosedCage::kAllSegments),
      may_have_holes(of.may_have_holes),
      is_blended(has_two_levels),
      hanging_blocks(static_cast<int>(hanging / kBlock)),
      pairs(of.pairs),
      cage(&of.cage),
      boxes(common.boxes),
      slab(common.slab),
      segments(of.cage.segments),
      level(of.level),
      floats_of_a_key(common.floats_of_a_key)
{
}

LatticeGrid::LatticeGrid(const GridSubject& of, const Common& common, const LatticeContents& contents) noexcept
    : IGrid(of, common, true, contents.coarse[0] != contents.fine[0], contents.hanging.size()), LatticeContents(contents)
{
}

MeshGrid::MeshGrid(const GridSubject& of, const TriangleTree& tree, const Material* only) noexcept
    : IGrid(of, {}, false, false, 0),
      triangles(tree),
      material(only),
      has_normals(!of.cage.slot->cage.normals.empty()),
      has_uv{of.cage.slot->cage.uv_sets.size() > 0, of.cage.slot->cage.uv_sets.size() > 1},
      has_colors(!of.cage.slot->cage.colors.empty())
{
}

Box3f IGrid::bounds() const noexcept
{
    Box3f box;
    for (int key = 0; key <= segments; ++key) box.add(bounds_at_key(key));
    return box;
}

Box3f IGrid::bounds_at_key(int key) const noexcept
{
    Box3f box = is_lattice ? boxes.at_key(key).bounds() : mesh().triangles.bounds(key);
    // Gap triangles may reach beyond the tile on whose side they lie.
    if (hanging_blocks > 0) box.add(lattice().hanging_boxes.at_key(key).bounds());
    return box;
}

}  // namespace occam::accel
