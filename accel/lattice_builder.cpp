#include "accel/lattice_builder.h"

#include <algorithm>

namespace occam::accel {
namespace {

template <class T>
std::span<T> kept(const std::vector<T>& from, Arena& arena)
{
    const std::span<T> to = arena.make_array<T>(from.size());
    std::uninitialized_copy(from.begin(), from.end(), to.begin());
    return to;
}

}  // namespace

LatticeGrid* LatticeBuilder::build(const GridSubject& of, std::span<const PatchTile> patches, Arena& arena)
{
    clear();
    keys_ = of.cage.segments + 1;
    for (std::uint32_t p = 0; p < patches.size(); ++p) {
        diced_.reset();
        const lod::LevelGrid vertices = dicer_.dice_pair(of.cage, patches[p].tile, patches[p].coarser, diced_);
        blends_ |= vertices.blends();
        parts_.emplace_back(vertices, patches[p].coarser.filter, static_cast<std::uint32_t>(fine_[0].size()));
        add_vertices(parts_[p], vertices);
        const std::size_t first_hanging = hanging_.size();
        add_hanging(parts_[p], p, vertices);
        add_blocks(parts_[p], p, first_hanging);
        micropolygons += std::uint64_t(2) * parts_[p].tile.columns * parts_[p].tile.rows;
    }
    vertex_count_ = fine_[0].size();
    for (int key = 1; key < keys_; ++key)
        for (std::uint32_t p = 0; p < patches.size(); ++p) {
            diced_.reset();
            add_vertices(parts_[p], dicer_.dice_pair(of.cage.keys[key], patches[p].tile, patches[p].coarser, diced_));
        }
    return finish(of, arena);
}

void LatticeBuilder::clear()
{
    for (int a = 0; a < 3; ++a) {
        fine_[a].clear();
        coarse_[a].clear();
    }
    parts_.clear();
    blocks_.clear();
    block_hanging_.clear();
    hanging_.clear();
    hanging_quads_.clear();
    blends_ = false;
}

// Copies a patch's vertices at one key. Rows run along the longer side.
void LatticeBuilder::add_vertices(const IGridPart& part, const lod::LevelGrid& vertices)
{
    const auto copy = [&](float* const(&from)[3], std::vector<float>(&to)[3]) {
        const int lattice = part.is_transposed ? vertices.width() * vertices.height() : 0;
        for (int a = 0; a < 3; ++a) {
            for (int s = 0; s <= part.slow() && part.is_transposed; ++s)
                for (int f = 0; f <= part.fast(); ++f) to[a].push_back(from[a][vertices.index(s, f)]);
            to[a].insert(to[a].end(), from[a] + lattice, from[a] + vertices.vertex_count);
        }
    };
    copy(vertices.fine, fine_);
    copy(vertices.coarse, coarse_);
}

// Copies a patch's T-vertices. Their ends become vertices of the new igrid: the lattice may be transposed, and what follows
// it is not.
void LatticeBuilder::add_hanging(const IGridPart& part, std::uint32_t number, const lod::LevelGrid& vertices)
{
    const auto moved = [&](std::uint32_t at) {
        const auto lattice = static_cast<std::uint32_t>(vertices.width() * vertices.height()),
                   width = static_cast<std::uint32_t>(vertices.width());
        return at < lattice ? part.vertex(static_cast<int>(at % width), static_cast<int>(at / width)) : part.first + at;
    };
    for (lod::Hanging h : vertices.hanging) {
        h.a = moved(h.a);
        h.c = moved(h.c);
        hanging_.push_back(h);
        hanging_quads_.push_back(make_id(number, h.i, h.j, 0));
    }
}

// Cuts a patch into blocks. They are ordered by halving the longer side, so that the binary tree over them reproduces the
// halving.
void LatticeBuilder::add_blocks(const IGridPart& part, std::uint32_t number, std::size_t first_hanging)
{
    const auto add_block = [&](int f0, int f1, int s0, int s1) {
        const auto before = static_cast<std::uint32_t>(block_hanging_.size());
        for (std::size_t h = first_hanging; h < hanging_.size(); ++h) {
            if (!hanging_[h].is_inside) continue;
            const int f = part.is_transposed ? hanging_[h].j : hanging_[h].i,
                      s = part.is_transposed ? hanging_[h].i : hanging_[h].j;
            if (f < f0 || f > f1 || s < s0 || s > s1) continue;
            block_hanging_.push_back(
                {static_cast<std::uint32_t>(h), static_cast<std::uint8_t>(f - f0), static_cast<std::uint8_t>(s - s0)});
        }
        blocks_.push_back(
            {.first = part.first + static_cast<std::uint32_t>(s0) * part.width + static_cast<std::uint32_t>(f0),
             .stride = static_cast<std::uint16_t>(part.width),
             .columns = static_cast<std::uint8_t>(f1 - f0),
             .rows = static_cast<std::uint8_t>(s1 - s0),
             .fast = static_cast<std::uint8_t>(f0),
             .slow = static_cast<std::uint8_t>(s0),
             .is_transposed = part.is_transposed,
             .part = static_cast<std::uint16_t>(number),
             .hanging_count = static_cast<std::uint16_t>(block_hanging_.size() - before),
             .hanging = before});
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
    cut(cut, 0, part.fast(), 0, part.slow());
}

// Makes a tree over boxes that are box_at(leaf, key).
template <class BoxAt>
BoxTree LatticeBuilder::box_tree(int leaves, Arena& arena, const BoxAt& box_at) const
{
    if (keys_ > 1) return make_moving_box_tree(leaves, keys_, arena, box_at);
    return make_still_box_tree(leaves, arena, [&](int leaf) { return box_at(leaf, 0); });
}

LatticeGrid* LatticeBuilder::finish(const GridSubject& of, Arena& arena)
{
    LatticeContents contents;
    // At all keys together; the coordinates along one axis lie together, key after key. Eight more floats are allocated,
    // since lanes are loaded eight at a time.
    const std::size_t count = fine_[0].size();
    const auto keep = [&](const std::vector<float>(&from)[3], const float*(&to)[3]) {
        float* data = arena.make_array<float>(3 * count + 8).data();
        for (std::size_t a = 0; a < 3; ++a) to[a] = std::copy(from[a].begin(), from[a].end(), data + a * count) - count;
        std::fill_n(data + 3 * count, 8, 0.0f);
    };
    keep(fine_, contents.fine);
    if (blends_) keep(coarse_, contents.coarse);
    else std::copy_n(contents.fine, 3, contents.coarse);
    contents.parts = kept(parts_, arena);
    contents.blocks = kept(blocks_, arena).data();
    contents.block_hanging = kept(block_hanging_, arena).data();
    if (!hanging_.empty()) keep_hanging(contents, arena);
    const BoxTree boxes = box_tree(static_cast<int>(blocks_.size()), arena, [&](int block, int key) {
        return box_of_block(blocks_[static_cast<std::size_t>(block)], key);
    });
    return arena.make<LatticeGrid>(of, IGrid::Common{boxes, slab(), static_cast<std::ptrdiff_t>(vertex_count_)}, contents);
}

void LatticeBuilder::keep_hanging(LatticeContents& contents, Arena& arena)
{
    // Copies of the last one fill its block.
    const std::size_t padded = (hanging_.size() + IGrid::kBlock - 1) / IGrid::kBlock * IGrid::kBlock;
    hanging_.resize(padded, lod::Hanging(hanging_.back()));
    hanging_quads_.resize(padded, std::uint32_t(hanging_quads_.back()));
    contents.hanging = kept(hanging_, arena);
    contents.hanging_quads = kept(hanging_quads_, arena).data();
    contents.hanging_boxes = box_tree(static_cast<int>(padded / IGrid::kBlock), arena, [&](int block, int key) {
        Box3f box;
        for (const lod::Hanging& h : contents.hanging.subspan(std::size_t(block) * IGrid::kBlock, IGrid::kBlock)) {
            add_to(box, h.a, key);
            add_to(box, h.c, key);
        }
        return box;
    });
}

// Adds a vertex, as both levels have it, to a box.
void LatticeBuilder::add_to(Box3f& box, std::uint32_t vertex, int key) const noexcept
{
    const std::size_t at = vertex + static_cast<std::size_t>(key) * vertex_count_;
    box.add(Vec3f(fine_[0][at], fine_[1][at], fine_[2][at]));
    if (blends_) box.add(Vec3f(coarse_[0][at], coarse_[1][at], coarse_[2][at]));
}

Box3f LatticeBuilder::box_of_block(const LatticeBlock& block, int key) const noexcept
{
    Box3f box;
    for (std::uint32_t row = 0; row <= block.rows; ++row)
        for (std::uint32_t column = 0; column <= block.columns; ++column)
            add_to(box, block.first + row * block.stride + column, key);
    // A T-vertex is anywhere between its ends, as each ray blends them; and one that moves is not where it was diced.
    for (std::uint32_t h = 0; (blends_ || keys_ > 1) && h < block.hanging_count; ++h) {
        const lod::Hanging& hanging = hanging_[block_hanging_[block.hanging + h].hanging];
        add_to(box, hanging.a, key);
        add_to(box, hanging.c, key);
    }
    return box;
}

// Returns a slab that bounds the vertices. Its normal is the sum of the cross products of the parts' diagonals, an average
// normal of the whole.
Slab LatticeBuilder::slab() const noexcept
{
    const auto at = [](const std::vector<float>(&p)[3], std::size_t v) { return Vec3f(p[0][v], p[1][v], p[2][v]); };
    Vec3f normal(0);
    for (const IGridPart& part : parts_) {
        const int c = part.tile.columns, r = part.tile.rows;
        const auto corner = [&](int i, int j) { return at(fine_, part.vertex(i, j)); };
        normal += glm::cross(corner(c, r) - corner(0, 0), corner(0, r) - corner(c, 0));
    }
    const float length = glm::length(normal);
    if (!(length > 0)) return {};
    Slab slab{normal / length, FLT_MAX, -FLT_MAX};
    for (std::size_t v = 0; v < fine_[0].size(); ++v)  // at all keys
        for (const float d :
             {glm::dot(slab.normal, at(fine_, v)), glm::dot(slab.normal, at(blends_ ? coarse_ : fine_, v))}) {
            slab.lo = std::min(slab.lo, d);
            slab.hi = std::max(slab.hi, d);
        }
    return slab;
}

}  // namespace occam::accel
