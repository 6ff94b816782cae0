// A tile of a patch, or the triangles of a cluster, ready to be met by rays ("igrid", Djeu et al. 2011, sec. 5.2.3).
//
// A *tile* keeps its vertices in rows and is cut into blocks of 4 x 2 quads; a *soup* is a list of triangles, eight a block: small
// patches of a cluster together, or a triangle mesh's own. Over the blocks lies a complete binary tree of boxes without
// pointers (Hou et al. 2010, sec. 3: halving the longer parametric side is within 20 % of greedy SAH); children of node n are
// 2n + 1 and 2n + 2, and the leaves are consecutive, so that a single ray can test eight of them at once.
//
// Space    the cage's dicing frame.   Memory  in one worker's arena; its tree borrows it.   Threads  one worker's own.
#pragma once

#include <cstdint>
#include <span>

#include "lod/dicer.h"
#include "lod/level_grid.h"

namespace occam::accel {

/// A quad of a tile: its lower left vertex; and which triangle: 0 (v00, v10, v11), 1 (v00, v11, v01).
struct QuadRef {
    std::uint16_t i, j;
    std::uint8_t triangle;
};

/// Boxes as a structure of arrays, node after node.
struct BoxTree {
    int leaves = 0;  ///< a power of two
    float* lo[3] = {};
    float* hi[3] = {};

    int first_leaf() const noexcept { return leaves - 1; }
};

/// One patch of a soup, or the tile's own.
struct IGridPart {
    lod::TileRef tile;
    lod::GridAttributes attributes;  ///< made when a hit first asks
    bool is_shaded = false;
};

struct IGrid {
    static constexpr int kBlock = 8;  ///< quads or triangles a block

    const lod::PosedCage* cage = nullptr;
    BoxTree boxes;                    ///< one leaf a block; empty boxes pad to a power of two
    bool is_tile = false;
    bool has_mask = false;            ///< hits ask the HitFilter

    // Tile
    const float* rows[3] = {};        ///< vertices; the fast axis has a multiple of four quads
    int width = 0;                    ///< vertices of a row
    bool is_transposed = false;       ///< rows run along v
    const std::uint16_t* block_quads = nullptr;  ///< each block's two strips of four quads: (fast << 8 | slow) twice

    // Soup
    const float* corners[9] = {};     ///< a.x a.y a.z b.x .. c.z, padded with copies to whole blocks
    const std::uint32_t* ids = nullptr;  ///< part << 16 | quad j << 9 | i << 1 | triangle; of triangle meshes: the face

    // Closers of all parts, laid out as a soup, each block with a box.
    int closer_blocks = 0;
    const float* closer_corners[9] = {};
    const std::uint32_t* closer_ids = nullptr;
    BoxTree closer_boxes;

    std::span<IGridPart> parts;       ///< empty for a triangle mesh
    std::uint64_t visit = 0;          ///< mailbox: the packet that met it last,
    std::uint32_t visited_lanes = 0;  ///< and which of its rays

    int block_count() const noexcept { return boxes.leaves; }
};

/// A micropolygon by number: closers have the top bit.
inline constexpr std::uint32_t kCloserBit = 0x80000000u;

/// Builds igrids. Scratch is reused; results are in the arena.
class IGridBuilder {
public:
    explicit IGridBuilder(lod::Dicer& dicer) : dicer_(dicer) {}

    IGrid* build_tile(const lod::PosedCage& cage, const lod::TileRef& tile, Arena& arena);
    /// Small patches of a cluster: each a whole patch of at most kSmallQuads quads.
    IGrid* build_patches(const lod::PosedCage& cage, std::span<const lod::TileRef> tiles, Arena& arena);
    /// Faces of a triangle mesh.
    IGrid* build_triangles(const lod::PosedCage& cage, std::span<const std::uint32_t> faces, Arena& arena);

    /// log2 of the quads below which a patch goes into a soup.
    static constexpr int kSmallExponent = 2;

    std::uint64_t micropolygons = 0;

private:
    struct Corner3 {
        Vec3f a, b, c;
    };
    void add_closers(std::uint32_t part, const lod::LevelGrid& grid);
    void finish_closers(IGrid& grid, Arena& arena);
    /// Lays triangles out in blocks of eight; returns the block count.
    int lay_out(const std::vector<Corner3>& triangles, const float* (&corners)[9], BoxTree& boxes, Arena& arena);

    lod::Dicer& dicer_;
    std::vector<Corner3> triangles_, closers_;
    std::vector<std::uint32_t> ids_, closer_ids_;
};

/// Quad and triangle of a soup's or a closer's id.
inline QuadRef quad_of(std::uint32_t id) noexcept
{
    return {static_cast<std::uint16_t>(id >> 1 & 0xff), static_cast<std::uint16_t>(id >> 9 & 0x7f), static_cast<std::uint8_t>(id & 1)};
}
inline std::uint32_t part_of(std::uint32_t id) noexcept { return id >> 16 & 0x7fff; }
inline std::uint32_t make_id(std::uint32_t part, int i, int j, int triangle) noexcept
{
    return part << 16 | static_cast<std::uint32_t>(j << 9 | i << 1 | triangle);
}

}  // namespace occam::accel
