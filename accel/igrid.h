// Holds a tile of a patch, small patches of a cluster, or the triangles of a cluster, ready for intersection by rays
// (an "igrid", Djeu et al. 2011, sec. 5.2.3).
//
// A *lattice* igrid has vertices in rows and is cut into blocks of up to 4 x 2 quads (made by LatticeBuilder). Over the
// blocks lies a complete binary tree of boxes without pointers (Hou et al. 2010, sec. 3: halving the longer parametric side
// is within 20 % of greedy SAH). The children of node n are 2n + 1 and 2n + 2. The leaves are consecutive, so that a single
// ray can test eight of them at once. A *mesh* igrid (made by MeshBuilder) has triangles in a tree of its own
// (accel/triangle_tree.h).
//
// A lattice serves a pair of levels: each vertex has a fine and a coarse position, and each ray blends them for itself
// (lod/ray_levels.h). T-vertices have neither: each is the midpoint of two blended edge vertices.
//
// An igrid of a cage that moves holds positions and boxes at each key of the cage's motion, one key after the other. A ray
// interpolates them at its own time first, and then blends levels (Hou et al. 2010: the boxes are hyper-trapezoids).
//
// Space    The cage's dicing frame.
// Memory   An arena; the tree borrows the igrid.
// Threads  Read only, except for `visit` and what phase one fills in.
#pragma once

#include <cfloat>
#include <cstdint>
#include <span>

#include "accel/box_tree.h"
#include "accel/triangle_tree.h"
#include "lod/level_grid.h"

namespace occam::accel {

/// A range of pairs of levels, both ends included.
struct PairRange {
    int finest = 0, coarsest = 0;
    bool has(int pair) const noexcept { return finest <= pair && pair <= coarsest; }
    bool is_empty() const noexcept { return finest > coarsest; }
};

/// Names a triangle by its quad in a tile (the lower left vertex) and its number: 0 is (v00, v10, v11), 1 is (v00, v11,
/// v01).
struct QuadRef {
    std::uint16_t i, j;
    std::uint8_t triangle;
};

/// The space between two parallel planes, lo <= dot(normal, p) <= hi. By default it is all of space.
struct Slab {
    Vec3f normal{0};  ///< unit length, or 0
    float lo = -FLT_MAX, hi = FLT_MAX;
};

/// Returns by how much the computed distance of a point from a plane may be off if coordinates are no larger than this: by
/// the rounding of products and sums, and by as much again in the test of triangles.
constexpr float slab_rounding(float coordinate) noexcept { return coordinate * (256 * 0x1p-24f); }

/// Bounds an igrid by the intersection of a box and a slab.
struct GridBounds {
    Box3f box;
    Slab slab;
};

/// Describes one patch of a lattice: a tile of it, or all of a small patch.
struct IGridPart {
    /// vertices        the diced tile
    /// coarse_filter   PatchRates::filter of the coarser level
    /// first           index of the patch's first vertex in the igrid
    IGridPart(const lod::LevelGrid& vertices, int coarse_filter, std::uint32_t first) noexcept;

    // What shading makes at the first hit.
    lod::GridAttributes attributes;
    const Material* material = nullptr;
    /// The values of VertexShader for the fine and the coarse level (accel/vertex_values.h); null until they are made.
    const float* values[2] = {};
    bool is_shaded = false;     ///< published, like values and channels
    std::int8_t channels = -1;  ///< floats per vertex in these values; negative until it is first asked for

    lod::TileRef tile;
    bool is_transposed;          ///< rows run along v
    bool is_halved;              ///< the patch has half as many rows and columns in the pair's coarser level
    std::int8_t coarse_filter;   ///< PatchRates::filter of the coarser level
    std::uint32_t first, width;  ///< index of the first vertex; vertices per row

    int fast() const noexcept { return is_transposed ? tile.rows : tile.columns; }  ///< quads along a row
    int slow() const noexcept { return is_transposed ? tile.columns : tile.rows; }  ///< rows of quads
    /// Returns the rates at the pair's coarser level, except those of the sides.
    lod::PatchRates coarser() const noexcept
    {
        lod::PatchRates rates = tile.rates;
        rates.u -= is_halved;
        rates.v -= is_halved;
        rates.filter = coarse_filter;
        return rates;
    }
    std::uint32_t vertex(int i, int j) const noexcept
    {
        return first + static_cast<std::uint32_t>(is_transposed ? i : j) * width +
               static_cast<std::uint32_t>(is_transposed ? j : i);
    }
};

/// A block of quads side by side in one row or two.
struct LatticeBlock {
    std::uint32_t first;         ///< index of the lower left vertex
    std::uint16_t stride;        ///< vertices per row
    std::uint8_t columns, rows;  ///< quads: 1 to 4, 1 or 2
    std::uint8_t fast, slow;     ///< the block's first quad in the part, along a row and across rows
    bool is_transposed;
    std::uint16_t part;
    std::uint16_t hanging_count;
    std::uint32_t hanging;  ///< index of its first T-vertex in LatticeGrid::block_hanging

    static constexpr int kColumns = 5, kRows = 3;  ///< the largest number of vertices
};

/// A T-vertex of a block.
struct BlockHanging {
    std::uint32_t hanging = 0;  ///< index in LatticeGrid::hanging
    std::uint8_t column = 0, row = 0;
};

/// The mailbox of an igrid: the packet that was tested against it last, and which of the packet's rays were.
struct GridVisit {
    std::uint64_t packet = 0;
    std::uint32_t lanes = 0;
};

/// Says whose surface an igrid holds, and which rays see it.
struct GridSubject {
    const lod::PosedCage& cage;
    PairRange pairs;              ///< the pairs of levels whose rays see this igrid
    int level;                    ///< level of the fine positions; 0 for a mesh
    bool may_have_holes = false;  ///< rays may pass some surface here while they are traced (accel/holes.h)
};

struct LatticeGrid;
struct MeshGrid;

/// What lattices and meshes have in common: all that rays read before they test micropolygons.
struct IGrid {
    static constexpr int kBlock = 8;  ///< quads per block

    // The fields that every visit reads come first, in few cache lines.
    GridVisit visit;  ///< used by the one worker that owns the tree; workers that share a tree have tables instead
    const bool is_lattice;
    const bool is_hidden;  ///< from some rays, by their kind or by their time: see the cage's seen_by and visible_in
    const bool may_have_holes;
    const bool is_blended;
    const int hanging_blocks;  ///< blocks of gap triangles
    const PairRange pairs;
    const lod::PosedCage* const cage;
    const BoxTree boxes;  ///< of a lattice: one leaf per block; empty boxes pad the leaves to a power of two
    const Slab slab;      ///< bounds all vertices, fine and coarse, at all keys
    const int segments;   ///< of the cage's motion; 0: the igrid stands still
    const int level;
    /// If a lattice moves: the number of floats from a coordinate to the same one at the next key.
    const std::ptrdiff_t floats_of_a_key;

    /// Return the igrid as what it is; is_lattice says which.
    const LatticeGrid& lattice() const noexcept;
    LatticeGrid& lattice() noexcept;
    const MeshGrid& mesh() const noexcept;

    /// Returns whether vertices move from a fine to a coarse position.
    bool blends() const noexcept { return is_blended; }
    /// Returns a box that holds everything at all keys.
    Box3f bounds() const noexcept;
    Box3f bounds_at_key(int key) const noexcept;

    /// What builders make for either kind.
    struct Common {
        BoxTree boxes;
        Slab slab;
        std::ptrdiff_t floats_of_a_key = 0;
    };

protected:
    IGrid(const GridSubject& of, const Common& common, bool is_lattice, bool is_blended, std::size_t hanging) noexcept;
};

/// What an igrid of patches holds.
struct LatticeContents {
    const float* fine[3] = {};    ///< positions, key after key
    const float* coarse[3] = {};  ///< the same arrays as the fine ones if nothing blends
    const LatticeBlock* blocks = nullptr;
    BoxTree hanging_boxes;
    const BlockHanging* block_hanging = nullptr;
    /// All T-vertices with a gap triangle here, padded with copies to blocks of eight.
    std::span<const lod::Hanging> hanging;
    /// For each T-vertex: its place, as that of a micropolygon, which its gap triangle reports.
    const std::uint32_t* hanging_quads = nullptr;
    std::span<IGridPart> parts;
};

struct LatticeGrid : IGrid, LatticeContents {
    LatticeGrid(const GridSubject& of, const Common& common, const LatticeContents& contents) noexcept;

    Vec3f fine_at(std::uint32_t v) const noexcept { return at(fine, v); }
    Vec3f coarse_at(std::uint32_t v) const noexcept { return at(coarse, v); }
    /// Return where a vertex is at a key.
    Vec3f fine_at(std::uint32_t v, int key) const noexcept { return at(fine, v + key * floats_of_a_key); }
    Vec3f coarse_at(std::uint32_t v, int key) const noexcept { return at(coarse, v + key * floats_of_a_key); }

private:
    static Vec3f at(const float* const (&p)[3], std::ptrdiff_t i) noexcept { return {p[0][i], p[1][i], p[2][i]}; }
};

struct MeshGrid : IGrid {
    MeshGrid(const GridSubject& of, const TriangleTree& tree, const Material* material) noexcept;

    const TriangleTree triangles;
    const Material* const material;  ///< the material of all triangles; null if they have several
    /// What the vertices of the cage have beside positions.
    const bool has_normals, has_uv[2], has_colors;
};

inline LatticeGrid& IGrid::lattice() noexcept { return static_cast<LatticeGrid&>(*this); }
inline const LatticeGrid& IGrid::lattice() const noexcept { return static_cast<const LatticeGrid&>(*this); }
inline const MeshGrid& IGrid::mesh() const noexcept { return static_cast<const MeshGrid&>(*this); }

/// Marks the numbers of gap triangles among those of micropolygons: it is their top bit.
inline constexpr std::uint32_t kGapBit = 0x80000000u;

/// Decodes the ids of a lattice into part, quad and triangle.
inline QuadRef quad_of(std::uint32_t id) noexcept
{
    return {static_cast<std::uint16_t>(id >> 1 & 0xff), static_cast<std::uint16_t>(id >> 9 & 0x7f),
            static_cast<std::uint8_t>(id & 1)};
}
inline std::uint32_t part_of(std::uint32_t id) noexcept { return id >> 16 & 0x7fff; }
inline std::uint32_t make_id(std::uint32_t part, int i, int j, int triangle) noexcept
{
    return part << 16 | static_cast<std::uint32_t>(j << 9 | i << 1 | triangle);
}

}  // namespace occam::accel
