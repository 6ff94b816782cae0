#include "accel/igrid.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace occam::accel {
namespace {

constexpr std::size_t kFewTriangles = 4;  // so few triangles form one block
constexpr float kInfinity = std::numeric_limits<float>::infinity();

BoxTree make_boxes(int blocks, int keys, Arena& arena)
{
    BoxTree tree;
    tree.leaves = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(1, blocks))));
    const int groups = tree.group_count() * keys;
    tree.data = arena.make_array<float>(std::size_t(groups) * BoxTree::kFloats).data();
    for (int g = 0; g < groups; ++g) {
        float* group = tree.data + g * BoxTree::kFloats;
        std::fill_n(group, BoxTree::kFloats / 2, kInfinity);
        std::fill_n(group + BoxTree::kFloats / 2, BoxTree::kFloats / 2, -kInfinity);
    }
    return tree;
}

void set_leaf(const BoxTree& tree, int leaf, const Box3f& box, float pad)
{
    const int node = tree.first_leaf() + leaf;
    for (int a = 0; a < 3; ++a) {
        tree.lo(node, a) = box.lo[a] - pad;
        tree.hi(node, a) = box.hi[a] + pad;
    }
}

// Sets a leaf's box at each key to box_at(key). It is grown by 2 ulps of its largest coordinate or, because positions
// between keys are rounded too, by 4 ulps of the largest one of all keys.
template <class BoxAt>
void set_leaf_at_keys(const BoxTree& tree, int leaf, int keys, BoxAt&& box_at)
{
    if (keys == 1) {
        const Box3f box = box_at(0);
        if (!box.is_empty()) set_leaf(tree, leaf, box, box.largest_coordinate() * 2 * std::numeric_limits<float>::epsilon());
        return;
    }
    float largest = 0;
    for (int key = 0; key < keys; ++key) largest = std::max(largest, box_at(key).largest_coordinate());
    for (int key = 0; key < keys; ++key)
        set_leaf(tree.at_key(key), leaf, box_at(key), largest * 4 * std::numeric_limits<float>::epsilon());
}

// Makes the nodes above the leaves of the box tree.
void finish_boxes(const BoxTree& of_all, int keys)
{
    for (int key = 0; key < keys; ++key) {
        const BoxTree tree = of_all.at_key(key);
        for (int n = tree.first_leaf() - 1; n >= 0; --n)
            for (int a = 0; a < 3; ++a) {
                tree.lo(n, a) = std::min(tree.lo(2 * n + 1, a), tree.lo(2 * n + 2, a));
                tree.hi(n, a) = std::max(tree.hi(2 * n + 1, a), tree.hi(2 * n + 2, a));
            }
    }
}

void add_vertex(const IGrid& grid, Box3f& box, std::uint32_t vertex, int key)
{
    box.add(grid.fine_at(vertex, key));
    if (grid.blends()) box.add(grid.coarse_at(vertex, key));
}

// The number of keys at which an igrid holds positions.
int keys_of(const IGrid& grid) { return grid.segments + 1; }

}  // namespace

Box3f IGrid::bounds() const noexcept
{
    Box3f box;
    for (int key = 0; key <= segments; ++key) {
        box.add(boxes.at_key(key).bounds());
        // Gap triangles may reach beyond the tile on whose side they lie.
        if (hanging_blocks > 0) box.add(hanging_boxes.at_key(key).bounds());
    }
    return box;
}

// Copies a patch's vertices at one key.
void IGridBuilder::add_vertices(const IGridPart& part, const lod::LevelGrid& vertices)
{
    const int fast = part.is_transposed ? part.tile.rows : part.tile.columns,
              slow = part.is_transposed ? part.tile.columns : part.tile.rows;
    const auto copy = [&](float* const(&from)[3], std::vector<float>(&to)[3]) {
        const int lattice = part.is_transposed ? vertices.width() * vertices.height() : 0;
        for (int a = 0; a < 3; ++a) {
            for (int s = 0; s <= slow && part.is_transposed; ++s)
                for (int f = 0; f <= fast; ++f) to[a].push_back(from[a][vertices.index(s, f)]);
            to[a].insert(to[a].end(), from[a] + lattice, from[a] + vertices.vertex_count);
        }
    };
    copy(vertices.fine, fine_);
    copy(vertices.coarse, coarse_);
}

// Copies a patch's vertices, blocks and T-vertices into the igrid. Rows run along the longer side.
void IGridBuilder::add_part(IGrid& grid, std::uint32_t number, const lod::LevelGrid& vertices)
{
    IGridPart& part = grid.parts[number];
    part = {};
    part.tile = vertices.tile;
    part.is_halved = vertices.is_halved;
    part.is_transposed = part.tile.rows > part.tile.columns;
    part.first = static_cast<std::uint32_t>(fine_[0].size());
    const int fast = part.is_transposed ? part.tile.rows : part.tile.columns,
              slow = part.is_transposed ? part.tile.columns : part.tile.rows;
    part.width = static_cast<std::uint32_t>(fast + 1);
    micropolygons += std::uint64_t(2) * part.tile.columns * part.tile.rows;

    add_vertices(part, vertices);

    // These are vertices of the new igrid: the lattice may be transposed, and what follows is not.
    const auto moved = [&](std::uint32_t at) {
        const auto lattice = static_cast<std::uint32_t>(vertices.width() * vertices.height()),
                   width = static_cast<std::uint32_t>(vertices.width());
        return at < lattice ? part.vertex(static_cast<int>(at % width), static_cast<int>(at / width)) : part.first + at;
    };
    const std::size_t first_hanging = hanging_.size();
    for (lod::Hanging h : vertices.hanging) {
        h.a = moved(h.a);
        h.c = moved(h.c);
        hanging_.push_back(h);
        hanging_quads_.push_back(make_id(number, h.i, h.j, 0));
    }

    // The blocks are ordered by halving the longer side, so that the binary tree over them reproduces the halving.
    const auto add_block = [&](int f0, int f1, int s0, int s1) {
        LatticeBlock block;
        block.first = part.first + static_cast<std::uint32_t>(s0) * part.width + static_cast<std::uint32_t>(f0);
        block.stride = static_cast<std::uint16_t>(part.width);
        block.columns = static_cast<std::uint8_t>(f1 - f0);
        block.rows = static_cast<std::uint8_t>(s1 - s0);
        block.fast = static_cast<std::uint8_t>(f0);
        block.slow = static_cast<std::uint8_t>(s0);
        block.is_transposed = part.is_transposed;
        block.part = static_cast<std::uint16_t>(number);
        block.hanging = static_cast<std::uint32_t>(block_hanging_.size());
        for (std::size_t h = first_hanging; h < hanging_.size(); ++h) {
            if (!hanging_[h].is_inside) continue;
            const int f = part.is_transposed ? hanging_[h].j : hanging_[h].i,
                      s = part.is_transposed ? hanging_[h].i : hanging_[h].j;
            if (f < f0 || f > f1 || s < s0 || s > s1) continue;
            block_hanging_.push_back(
                {static_cast<std::uint32_t>(h), static_cast<std::uint8_t>(f - f0), static_cast<std::uint8_t>(s - s0)});
            ++block.hanging_count;
        }
        blocks_.push_back(block);
    };
    const auto cut = [&](const auto& self, int f0, int f1, int s0, int s1) -> void {
        const int columns = f1 - f0, rows = s1 - s0;
        if (columns <= 4 && rows <= 2) {
            add_block(f0, f1, s0, s1);
        } else if (columns > 4 && (columns >= rows || rows <= 2)) {
            self(self, f0, (f0 + f1) / 2, s0, s1);
            self(self, (f0 + f1) / 2, f1, s0, s1);
        } else {
            self(self, f0, f1, s0, (s0 + s1) / 2);
            self(self, f0, f1, (s0 + s1) / 2, s1);
        }
    };
    cut(cut, 0, fast, 0, slow);
}

void IGridBuilder::finish_hanging(IGrid& grid, Arena& arena)
{
    const std::size_t count = hanging_.size();
    if (count == 0) return;
    grid.hanging_blocks = static_cast<int>((count + IGrid::kBlock - 1) / IGrid::kBlock);
    const std::size_t padded = static_cast<std::size_t>(grid.hanging_blocks) * IGrid::kBlock;
    const std::span<lod::Hanging> kept = arena.make_array<lod::Hanging>(padded);
    const std::span<std::uint32_t> quads = arena.make_array<std::uint32_t>(padded);
    grid.hanging_boxes = make_boxes(grid.hanging_blocks, keys_of(grid), arena);
    for (std::size_t h = 0; h < padded; ++h) {
        kept[h] = hanging_[std::min(h, count - 1)];
        quads[h] = hanging_quads_[std::min(h, count - 1)];
    }
    for (int block = 0; block < grid.hanging_blocks; ++block)
        set_leaf_at_keys(grid.hanging_boxes, block, keys_of(grid), [&](int key) {
            Box3f box;
            for (const lod::Hanging& hanging : kept.subspan(std::size_t(block) * IGrid::kBlock, IGrid::kBlock)) {
                add_vertex(grid, box, hanging.a, key);
                add_vertex(grid, box, hanging.c, key);
            }
            return box;
        });
    finish_boxes(grid.hanging_boxes, keys_of(grid));
    grid.hanging = kept;
    grid.hanging_quads = quads.data();
}

void IGridBuilder::finish(IGrid& grid, bool blends, Arena& arena)
{
    grid.is_lattice = true;
    // At all keys together; the coordinates along one axis lie together, key after key.
    const std::size_t count = fine_[0].size();
    grid.floats_of_a_key = static_cast<std::ptrdiff_t>(count) / keys_of(grid);
    // Eight more floats are allocated, since lanes are loaded eight at a time.
    const auto keep = [&](const std::vector<float>(&from)[3], const float*(&to)[3]) {
        float* data = arena.make_array<float>(3 * count + 8).data();
        for (std::size_t a = 0; a < 3; ++a) to[a] = std::copy(from[a].begin(), from[a].end(), data + a * count) - count;
        std::fill_n(data + 3 * count, 8, 0.0f);
    };
    keep(fine_, grid.fine);
    if (blends) {
        keep(coarse_, grid.coarse);
    } else {
        for (int a = 0; a < 3; ++a) grid.coarse[a] = grid.fine[a];
    }
    const std::span<LatticeBlock> blocks = arena.make_array<LatticeBlock>(blocks_.size());
    std::copy(blocks_.begin(), blocks_.end(), blocks.begin());
    grid.blocks = blocks.data();
    const std::span<BlockHanging> block_hanging = arena.make_array<BlockHanging>(block_hanging_.size());
    std::copy(block_hanging_.begin(), block_hanging_.end(), block_hanging.begin());
    grid.block_hanging = block_hanging.data();
    finish_hanging(grid, arena);

    grid.boxes = make_boxes(static_cast<int>(blocks.size()), keys_of(grid), arena);
    for (std::size_t b = 0; b < blocks.size(); ++b)
        set_leaf_at_keys(grid.boxes, static_cast<int>(b), keys_of(grid),
                         [&](int key) { return box_of_block(grid, blocks[b], key); });
    finish_boxes(grid.boxes, keys_of(grid));
    finish_slab(grid);
}

Box3f IGridBuilder::box_of_block(const IGrid& grid, const LatticeBlock& block, int key) const noexcept
{
    Box3f box;
    for (std::uint32_t row = 0; row <= block.rows; ++row)
        for (std::uint32_t column = 0; column <= block.columns; ++column)
            add_vertex(grid, box, block.first + row * block.stride + column, key);
    // A T-vertex is anywhere between its ends, as each ray blends them; and one that moves is not where it was diced.
    for (std::uint32_t h = 0; (grid.blends() || grid.segments > 0) && h < block.hanging_count; ++h) {
        const lod::Hanging& hanging = hanging_[block_hanging_[block.hanging + h].hanging];
        add_vertex(grid, box, hanging.a, key);
        add_vertex(grid, box, hanging.c, key);
    }
    return box;
}

// Bounds the vertices by a slab. Its normal is the sum of the cross products of the parts' diagonals, an average normal
// of the whole.
void IGridBuilder::finish_slab(IGrid& grid) const
{
    Vec3f normal(0);
    for (const IGridPart& part : grid.parts) {
        const int c = part.tile.columns, r = part.tile.rows;
        normal += glm::cross(grid.fine_at(part.vertex(c, r)) - grid.fine_at(part.vertex(0, 0)),
                             grid.fine_at(part.vertex(0, r)) - grid.fine_at(part.vertex(c, 0)));
    }
    const float length = glm::length(normal);
    if (!(length > 0)) return;
    grid.slab = {normal / length, FLT_MAX, -FLT_MAX};
    for (std::uint32_t v = 0; v < fine_[0].size(); ++v)  // at all keys
        for (const float d : {glm::dot(grid.slab.normal, grid.fine_at(v)), glm::dot(grid.slab.normal, grid.coarse_at(v))}) {
            grid.slab.lo = std::min(grid.slab.lo, d);
            grid.slab.hi = std::max(grid.slab.hi, d);
        }
}

IGrid* IGridBuilder::build_patches(const lod::PosedCage& cage, std::span<const PatchTile> patches, Arena& arena)
{
    IGrid& grid = *arena.make<IGrid>();
    grid.cage = &cage;
    grid.segments = cage.segments;
    grid.parts = arena.make_array<IGridPart>(patches.size());
    for (auto* list : {&fine_[0], &fine_[1], &fine_[2], &coarse_[0], &coarse_[1], &coarse_[2]}) list->clear();
    blocks_.clear();
    block_hanging_.clear();
    hanging_.clear();
    hanging_quads_.clear();
    bool blends = false;
    for (std::uint32_t p = 0; p < patches.size(); ++p) {
        diced_.reset();
        const lod::LevelGrid vertices = dicer_.dice_pair(cage, patches[p].tile, patches[p].coarser, diced_);
        blends |= vertices.blends();
        add_part(grid, p, vertices);
        grid.parts[p].coarse_filter = static_cast<std::int8_t>(patches[p].coarser.filter);
    }
    for (int key = 1; key <= cage.segments; ++key)
        for (std::uint32_t p = 0; p < patches.size(); ++p) {
            diced_.reset();
            add_vertices(grid.parts[p], dicer_.dice_pair(cage.keys[key], patches[p].tile, patches[p].coarser, diced_));
        }
    finish(grid, blends, arena);
    return &grid;
}

IGrid* IGridBuilder::build_tile(const lod::PosedCage& cage, const PatchTile& tile, Arena& arena)
{
    return build_patches(cage, {&tile, 1}, arena);
}

// Assigns faces to the leaves [leaf, leaf + leaves) of the box tree, so that its halves are the parts of the split.
void IGridBuilder::cut_triangles(std::span<lod::BoxedFace> faces, int leaf, int leaves)
{
    const bool fits = faces.size() <= IGrid::kBlock;
    if (leaves > 1 && faces.size() > 1) {
        const lod::FaceSplit split = lod::split_faces(faces, static_cast<std::size_t>(leaves / 2) * IGrid::kBlock);
        if (split.pays || !fits) {
            cut_triangles(faces.first(split.count), leaf, leaves / 2);
            cut_triangles(faces.subspan(split.count), leaf + leaves / 2, leaves / 2);
            return;
        }
    }
    triangle_blocks_.push_back({leaf, faces});
}

IGrid* IGridBuilder::build_triangles(const lod::PosedCage& cage, std::span<const std::uint32_t> faces, Arena& arena)
{
    IGrid& grid = *arena.make<IGrid>();
    grid.cage = &cage;
    grid.segments = cage.segments;
    const Cage& source = cage.slot->cage;
    micropolygons += faces.size();
    boxed_.resize(faces.size());
    corners_.resize(3 * faces.size() * static_cast<std::size_t>(keys_of(grid)));
    // Triangles that move are distributed by where they are at the middle of the shutter.
    const int middle = cage.segments / 2;
    for (int key = 0; key <= cage.segments; ++key)
        for (std::uint32_t f = 0; f < faces.size(); ++f) {
            if (key == 0) boxed_[f] = {{}, f};
            for (std::size_t p = 0; p < 3; ++p) {
                const Vec3f at = cage.at_key(key).vertex(source.face_vertices[std::size_t(faces[f]) * 3 + p]);
                corners_[3 * (std::size_t(key) * faces.size() + f) + p] = at;
                if (key == middle) boxed_[f].box.add(at);
            }
        }
    // There are twice as many leaves as full blocks would take, and at least eight, which are tested at once: this
    // leaves room to distribute triangles by the space that they take.
    const auto full = static_cast<unsigned>((faces.size() + IGrid::kBlock - 1) / IGrid::kBlock);
    const int leaves = faces.size() <= kFewTriangles ? 1
                                                     : std::max(BoxTree::kGroup, 2 * static_cast<int>(std::bit_ceil(full)));
    triangle_blocks_.clear();
    cut_triangles(boxed_, 0, leaves);
    finish_triangles(grid, faces, leaves, arena);
    return &grid;
}

void IGridBuilder::finish_triangles(IGrid& grid, std::span<const std::uint32_t> faces, int leaves, Arena& arena)
{
    const auto keys = static_cast<std::size_t>(keys_of(grid));
    const std::size_t padded = triangle_blocks_.size() * IGrid::kBlock;
    const std::span<float> data = arena.make_array<float>(9 * padded * keys);
    const std::span<std::uint32_t> ids = arena.make_array<std::uint32_t>(padded);
    const std::span<std::uint16_t> block_at = arena.make_array<std::uint16_t>(static_cast<std::size_t>(leaves));
    std::fill(block_at.begin(), block_at.end(), std::uint16_t(0));
    grid.boxes = make_boxes(leaves, keys_of(grid), arena);
    grid.floats_of_a_key = static_cast<std::ptrdiff_t>(9 * padded);
    for (std::size_t b = 0; b < triangle_blocks_.size(); ++b) {
        const TriangleBlock& block = triangle_blocks_[b];
        // Copies of the last triangle fill its block: they are hit where it is hit, under the same number.
        const auto face_at = [&](std::size_t i) { return block.faces[std::min(i, block.faces.size() - 1)].face; };
        for (std::size_t i = 0; i < IGrid::kBlock; ++i) {
            const std::size_t k = b * IGrid::kBlock + i;
            ids[k] = faces[face_at(i)];
            for (std::size_t key = 0; key < keys; ++key)
                for (std::size_t p = 0; p < 3; ++p)
                    for (std::size_t a = 0; a < 3; ++a)
                        data[(key * 9 + p * 3 + a) * padded + k] =
                            corners_[3 * (key * faces.size() + face_at(i)) + p][static_cast<int>(a)];
        }
        block_at[static_cast<std::size_t>(block.leaf)] = static_cast<std::uint16_t>(b);
        set_leaf_at_keys(grid.boxes, block.leaf, keys_of(grid), [&](int key) {
            Box3f box;
            for (const lod::BoxedFace& face : block.faces)
                for (std::size_t p = 0; p < 3; ++p) box.add(corners_[3 * (std::size_t(key) * faces.size() + face.face) + p]);
            return box;
        });
    }
    finish_boxes(grid.boxes, keys_of(grid));
    for (std::size_t c = 0; c < 9; ++c) grid.corners[c] = &data[c * padded];
    grid.ids = ids.data();
    grid.block_at = block_at.data();
}

}  // namespace occam::accel
