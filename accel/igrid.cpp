#include "accel/igrid.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace occam::accel {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

BoxTree make_boxes(int blocks, Arena& arena)
{
    BoxTree tree;
    tree.leaves = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(1, blocks))));
    const int nodes = 2 * tree.leaves - 1;
    // Leaves are read eight at a time, past the last one too.
    const std::span<float> data = arena.make_array<float>(std::size_t(6) * (nodes + IGrid::kBlock));
    for (int a = 0; a < 3; ++a) {
        tree.lo[a] = &data[std::size_t(a) * (nodes + IGrid::kBlock)];
        tree.hi[a] = &data[std::size_t(a + 3) * (nodes + IGrid::kBlock)];
        std::fill_n(tree.lo[a], nodes + IGrid::kBlock, kInfinity);
        std::fill_n(tree.hi[a], nodes + IGrid::kBlock, -kInfinity);
    }
    return tree;
}

void add_to_box(BoxTree& tree, int node, Vec3f p)
{
    for (int a = 0; a < 3; ++a) {
        tree.lo[a][node] = std::min(tree.lo[a][node], p[a]);
        tree.hi[a][node] = std::max(tree.hi[a][node], p[a]);
    }
}

// Grows the leaves by 2 ulps of their largest coordinate, then makes the nodes above them.
void finish_boxes(BoxTree& tree)
{
    for (int n = tree.first_leaf(); n < 2 * tree.leaves - 1; ++n) {
        if (tree.lo[0][n] > tree.hi[0][n]) continue;
        float largest = 0;
        for (int a = 0; a < 3; ++a) largest = std::max({largest, std::fabs(tree.lo[a][n]), std::fabs(tree.hi[a][n])});
        const float pad = largest * 2 * std::numeric_limits<float>::epsilon();
        for (int a = 0; a < 3; ++a) {
            tree.lo[a][n] -= pad;
            tree.hi[a][n] += pad;
        }
    }
    for (int n = tree.first_leaf() - 1; n >= 0; --n)
        for (int a = 0; a < 3; ++a) {
            tree.lo[a][n] = std::min(tree.lo[a][2 * n + 1], tree.lo[a][2 * n + 2]);
            tree.hi[a][n] = std::max(tree.hi[a][2 * n + 1], tree.hi[a][2 * n + 2]);
        }
}

}  // namespace

int IGridBuilder::lay_out(const std::vector<Corner3>& triangles, const float* (&corners)[9], BoxTree& boxes, Arena& arena)
{
    const int count = static_cast<int>(triangles.size()), blocks = (count + IGrid::kBlock - 1) / IGrid::kBlock;
    const std::size_t padded = std::size_t(blocks) * IGrid::kBlock;
    const std::span<float> data = arena.make_array<float>(9 * padded);
    boxes = make_boxes(blocks, arena);
    for (std::size_t k = 0; k < padded; ++k) {
        // Copies of the last triangle fill its block: they hit where it hits, under the same number.
        const Corner3& t = triangles[std::min<std::size_t>(k, triangles.size() - 1)];
        const Vec3f* points[3] = {&t.a, &t.b, &t.c};
        for (int p = 0; p < 3; ++p) {
            for (int a = 0; a < 3; ++a) data[(p * 3 + a) * padded + k] = (*points[p])[a];
            add_to_box(boxes, boxes.first_leaf() + static_cast<int>(k) / IGrid::kBlock, *points[p]);
        }
    }
    finish_boxes(boxes);
    for (int c = 0; c < 9; ++c) corners[c] = &data[c * padded];
    return blocks;
}

void IGridBuilder::add_closers(std::uint32_t part, const lod::LevelGrid& grid)
{
    for (const lod::Closer& c : grid.closers) {
        closers_.push_back({c.a, c.middle, c.c});
        closer_ids_.push_back(make_id(part, c.i, c.j, 0));
    }
}

void IGridBuilder::finish_closers(IGrid& grid, Arena& arena)
{
    if (!closers_.empty()) {
        grid.closer_blocks = lay_out(closers_, grid.closer_corners, grid.closer_boxes, arena);
        const std::span<std::uint32_t> ids = arena.make_array<std::uint32_t>(std::size_t(grid.closer_blocks) * IGrid::kBlock);
        for (std::size_t k = 0; k < ids.size(); ++k) ids[k] = closer_ids_[std::min(k, closer_ids_.size() - 1)];
        grid.closer_ids = ids.data();
    }
    closers_.clear();
    closer_ids_.clear();
}

IGrid* IGridBuilder::build_tile(const lod::PosedCage& cage, const lod::TileRef& tile, Arena& arena)
{
    lod::LevelGrid vertices = dicer_.dice(cage, tile, arena);
    IGrid& grid = *arena.make<IGrid>();
    grid.cage = &cage;
    grid.is_tile = true;
    grid.parts = arena.make_array<IGridPart>(1);
    grid.parts[0] = {tile, {}, false};
    grid.is_transposed = tile.columns < 4;
    micropolygons += std::uint64_t(2) * tile.columns * tile.rows;

    const int fast = grid.is_transposed ? tile.rows : tile.columns, slow = grid.is_transposed ? tile.columns : tile.rows;
    grid.width = fast + 1;
    float* from[3] = {vertices.x, vertices.y, vertices.z};
    if (grid.is_transposed) {
        const std::size_t count = std::size_t(vertices.width()) * vertices.height();
        const std::span<float> turned = arena.make_array<float>(3 * count);
        for (int a = 0; a < 3; ++a)
            for (int j = 0; j <= tile.rows; ++j)
                for (int i = 0; i <= tile.columns; ++i) turned[a * count + std::size_t(i) * grid.width + j] = from[a][j * vertices.width() + i];
        for (int a = 0; a < 3; ++a) from[a] = &turned[a * count];
    }
    for (int a = 0; a < 3; ++a) grid.rows[a] = from[a];

    // A block: strips of four in two rows, or, of a single row, two strips one after the other (or one strip twice).
    const int strips = fast / 4, blocks_along = slow > 1 ? strips : std::max(1, strips / 2);
    const int blocks = blocks_along * std::max(1, slow / 2);
    grid.boxes = make_boxes(blocks, arena);
    const std::span<std::uint16_t> quads = arena.make_array<std::uint16_t>(std::size_t(2) * blocks);
    int leaf = 0;
    // Leaves in the order of halving the longer side, so that the binary tree over them is that halving.
    const auto visit = [&](const auto& self, int a0, int a1, int b0, int b1) -> void {
        if (a1 - a0 == 1 && b1 - b0 == 1) {
            const int s = slow > 1 ? b0 * 2 : 0;
            const int f[2] = {slow > 1 ? a0 * 4 : a0 * 8, slow > 1 ? a0 * 4 : std::min(a0 * 8 + 4, fast - 4)};
            for (int half = 0; half < 2; ++half) {
                const int row = slow > 1 ? s + half : 0;
                quads[leaf * 2 + half] = static_cast<std::uint16_t>(f[half] << 8 | row);
                for (int y = row; y <= row + 1; ++y)
                    for (int x = f[half]; x <= f[half] + 4; ++x) {
                        const int at = y * grid.width + x;
                        add_to_box(grid.boxes, grid.boxes.first_leaf() + leaf, {from[0][at], from[1][at], from[2][at]});
                    }
            }
            ++leaf;
        } else if ((a1 - a0) * 4 > (b1 - b0) * 2) {
            self(self, a0, (a0 + a1) / 2, b0, b1);
            self(self, (a0 + a1) / 2, a1, b0, b1);
        } else if (b1 - b0 > 1) {
            self(self, a0, a1, b0, (b0 + b1) / 2);
            self(self, a0, a1, (b0 + b1) / 2, b1);
        } else {
            self(self, a0, (a0 + a1) / 2, b0, b1);
            self(self, (a0 + a1) / 2, a1, b0, b1);
        }
    };
    visit(visit, 0, blocks_along, 0, std::max(1, slow / 2));
    finish_boxes(grid.boxes);
    grid.block_quads = quads.data();
    add_closers(0, vertices);
    finish_closers(grid, arena);
    return &grid;
}

IGrid* IGridBuilder::build_patches(const lod::PosedCage& cage, std::span<const lod::TileRef> tiles, Arena& arena)
{
    IGrid& grid = *arena.make<IGrid>();
    grid.cage = &cage;
    grid.parts = arena.make_array<IGridPart>(tiles.size());
    triangles_.clear();
    ids_.clear();
    for (std::uint32_t p = 0; p < tiles.size(); ++p) {
        grid.parts[p] = {tiles[p], {}, false};
        const lod::LevelGrid vertices = dicer_.dice(cage, tiles[p], arena);
        for (int j = 0; j < tiles[p].rows; ++j)
            for (int i = 0; i < tiles[p].columns; ++i) {
                const Vec3f v00 = vertices.vertex(i, j), v10 = vertices.vertex(i + 1, j);
                const Vec3f v01 = vertices.vertex(i, j + 1), v11 = vertices.vertex(i + 1, j + 1);
                triangles_.push_back({v00, v10, v11});
                ids_.push_back(make_id(p, i, j, 0));
                triangles_.push_back({v00, v11, v01});
                ids_.push_back(make_id(p, i, j, 1));
            }
        add_closers(p, vertices);
    }
    micropolygons += triangles_.size();
    const int blocks = lay_out(triangles_, grid.corners, grid.boxes, arena);
    const std::span<std::uint32_t> ids = arena.make_array<std::uint32_t>(std::size_t(blocks) * IGrid::kBlock);
    for (std::size_t k = 0; k < ids.size(); ++k) ids[k] = ids_[std::min(k, ids_.size() - 1)];
    grid.ids = ids.data();
    finish_closers(grid, arena);
    return &grid;
}

IGrid* IGridBuilder::build_triangles(const lod::PosedCage& cage, std::span<const std::uint32_t> faces, Arena& arena)
{
    IGrid& grid = *arena.make<IGrid>();
    grid.cage = &cage;
    triangles_.clear();
    const Cage& source = cage.slot->cage;
    for (const std::uint32_t f : faces) {
        const std::uint32_t* v = &source.face_vertices[std::size_t(f) * 3];
        triangles_.push_back({cage.pose(source.positions[v[0]]), cage.pose(source.positions[v[1]]), cage.pose(source.positions[v[2]])});
    }
    micropolygons += triangles_.size();
    const int blocks = lay_out(triangles_, grid.corners, grid.boxes, arena);
    const std::span<std::uint32_t> ids = arena.make_array<std::uint32_t>(std::size_t(blocks) * IGrid::kBlock);
    for (std::size_t k = 0; k < ids.size(); ++k) ids[k] = faces[std::min(k, faces.size() - 1)];
    grid.ids = ids.data();
    return &grid;
}

}  // namespace occam::accel
