// Holds a tile of a patch, small patches of a cluster, or the triangles of a cluster, ready for intersection by rays
// (an "igrid", Djeu et al. 2011, sec. 5.2.3).
//
// A *lattice* igrid has vertices in rows and is cut into blocks of up to 4 x 2 quads. A *mesh* igrid has triangles, up
// to eight per block, which the surface area heuristic distributes over the blocks (lod/face_split.h). Over the blocks
// lies a complete binary tree of boxes without pointers (Hou et al. 2010, sec. 3: halving the longer parametric side is
// within 20 % of greedy SAH). The children of node n are 2n + 1 and 2n + 2. The leaves are consecutive, so that a
// single ray can test eight of them at once.
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

#include "lod/dicer.h"
#include "lod/face_split.h"
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

/// Holds the boxes of a complete binary tree without pointers, in groups of eight: eight lo.x, eight lo.y, ..., eight
/// hi.z, so that values that are read together lie together. The leaves come first, then a spare slot, then the nodes
/// above them, starting with the root. So the eight nodes of the fourth row form a group, too.
struct BoxTree {
    static constexpr int kGroup = 8, kFloats = 6 * kGroup;

    int leaves = 0;  ///< a power of two
    float* data = nullptr;

    static constexpr int kFourthRow = 7;  ///< index of the first node of that row

    /// Returns the number of floats from a box at one key to the same box at the next key.
    std::ptrdiff_t floats_of_a_key() const noexcept { return std::ptrdiff_t(group_count()) * kFloats; }
    BoxTree at_key(int key) const noexcept { return {leaves, data + key * floats_of_a_key()}; }
    int first_leaf() const noexcept { return leaves - 1; }
    int node_count() const noexcept { return 2 * leaves - 1; }
    int group_count() const noexcept { return (2 * leaves + kGroup - 1) / kGroup; }
    /// Points at lo.x of a node; the next coordinate is kGroup floats further. Consecutive leaves lie side by side,
    /// starting at a multiple of eight.
    float* at(int node) const noexcept
    {
        const int place = node < first_leaf() ? leaves + 1 + node : node - first_leaf();
        return data + offset(static_cast<std::size_t>(place));
    }
    /// Returns the index of a box's lo.x among the groups.
    static constexpr std::size_t offset(std::size_t place) noexcept { return place / kGroup * kFloats + place % kGroup; }
    Box3f bounds() const noexcept { return {{lo(0, 0), lo(0, 1), lo(0, 2)}, {hi(0, 0), hi(0, 1), hi(0, 2)}}; }
    float& lo(int node, int axis) const noexcept { return at(node)[axis * kGroup]; }
    float& hi(int node, int axis) const noexcept { return at(node)[(axis + 3) * kGroup]; }
};

/// The space between two parallel planes, lo <= dot(normal, p) <= hi. By default it is all of space.
struct Slab {
    Vec3f normal{0};  ///< unit length, or 0
    float lo = -FLT_MAX, hi = FLT_MAX;
};

/// Bounds an igrid by the intersection of a box and a slab.
struct GridBounds {
    Box3f box;
    Slab slab;
};

/// Describes one patch of a lattice: a tile of it, or all of a small patch.
struct IGridPart {
    lod::TileRef tile;
    lod::GridAttributes attributes;  ///< made at the first hit, like the material
    const Material* material = nullptr;
    bool is_shaded = false;  ///< published, like values and channels
    /// The values of VertexShader for the fine and the coarse level (accel/vertex_values.h); null until they are made.
    const float* values[2] = {};
    std::int8_t channels = -1;      ///< floats per vertex in these values; negative until it is first asked for
    bool is_transposed = false;     ///< rows run along v
    bool is_halved = false;         ///< the patch has half as many rows and columns in the pair's coarser level
    std::int8_t coarse_filter = 0;  ///< PatchRates::filter of the coarser level
    std::uint32_t first = 0;        ///< index of the first vertex
    std::uint32_t width = 0;        ///< vertices per row

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
    std::uint32_t first = 0;             ///< index of the lower left vertex
    std::uint16_t stride = 0;            ///< vertices per row
    std::uint8_t columns = 0, rows = 0;  ///< quads: 1 to 4, 1 or 2
    std::uint8_t fast = 0, slow = 0;     ///< the block's first quad in the part, along a row and across rows
    bool is_transposed = false;
    std::uint16_t part = 0;
    std::uint16_t hanging_count = 0;
    std::uint32_t hanging = 0;  ///< index of its first T-vertex in IGrid::block_hanging

    static constexpr int kColumns = 5, kRows = 3;  ///< the largest number of vertices
};

/// A T-vertex of a block.
struct BlockHanging {
    std::uint32_t hanging = 0;  ///< index in IGrid::hanging
    std::uint8_t column = 0, row = 0;
};

/// The mailbox of an igrid: the packet that was tested against it last, and which of the packet's rays were.
struct GridVisit {
    std::uint64_t packet = 0;
    std::uint32_t lanes = 0;
};

struct IGrid {
    static constexpr int kBlock = 8;  ///< quads or triangles per block

    // The fields that every visit reads come first, in few cache lines.
    GridVisit visit;  ///< used by the one worker that owns the tree; workers that share a tree have tables instead
    bool is_lattice = false;
    bool is_hidden = false;  ///< from some rays, by their kind or by their time: see the cage's seen_by and visible_in
    int hanging_blocks = 0;
    PairRange pairs;  ///< the pairs of levels whose rays see this igrid
    const lod::PosedCage* cage = nullptr;
    BoxTree boxes;     ///< one leaf per block; empty boxes pad the leaves to a power of two
    Slab slab;         ///< bounds all vertices, fine and coarse, at all keys
    int segments = 0;  ///< of the cage's motion; 0: the igrid stands still
    /// If it moves: the number of floats from a coordinate in `fine`, `coarse` or `corners` to the same one at the next key.
    std::ptrdiff_t floats_of_a_key = 0;

    // Lattice
    const float* fine[3] = {};
    const float* coarse[3] = {};  ///< the same arrays as the fine ones if nothing blends
    const LatticeBlock* blocks = nullptr;
    BoxTree hanging_boxes;
    const BlockHanging* block_hanging = nullptr;
    /// All T-vertices with a gap triangle here, padded with copies to blocks of eight.
    std::span<const lod::Hanging> hanging;
    /// For each T-vertex: the micropolygon whose id its gap triangle reports.
    const std::uint32_t* hanging_quads = nullptr;
    std::span<IGridPart> parts;  ///< empty for a mesh
    int level = 0;               ///< level of the fine positions

    // Mesh
    const float* corners[9] = {};        ///< a.x a.y a.z b.x .. c.z, padded with copies to whole blocks
    const std::uint32_t* ids = nullptr;  ///< face index of each triangle
    /// The block of each leaf of `boxes`; a leaf without a block has an empty box.
    const std::uint16_t* block_at = nullptr;

    bool blends() const noexcept { return coarse[0] != fine[0]; }
    Vec3f fine_at(std::uint32_t v) const noexcept { return {fine[0][v], fine[1][v], fine[2][v]}; }
    Vec3f coarse_at(std::uint32_t v) const noexcept { return {coarse[0][v], coarse[1][v], coarse[2][v]}; }
    /// Return where a vertex is at a key.
    Vec3f fine_at(std::uint32_t v, int key) const noexcept { return at(fine, v + key * floats_of_a_key); }
    Vec3f coarse_at(std::uint32_t v, int key) const noexcept { return at(coarse, v + key * floats_of_a_key); }
    /// Returns a box that holds everything at all keys.
    Box3f bounds() const noexcept;

private:
    static Vec3f at(const float* const (&p)[3], std::ptrdiff_t i) noexcept { return {p[0][i], p[1][i], p[2][i]}; }
};

/// Marks the numbers of gap triangles among those of micropolygons: it is their top bit.
inline constexpr std::uint32_t kGapBit = 0x80000000u;

/// Builds igrids. The scratch memory is reused; the results lie in the arena.
class IGridBuilder {
public:
    explicit IGridBuilder(lod::Dicer& dicer) : dicer_(dicer) {}

    struct PatchTile {
        lod::TileRef tile;
        lod::PatchRates coarser;  ///< the patch's rates at the pair's coarser level
    };

    IGrid* build_tile(const lod::PosedCage& cage, const PatchTile& tile, Arena& arena);
    /// Builds an igrid of small patches of a cluster: each is a whole patch of at most 2^kSmallExponent quads.
    IGrid* build_patches(const lod::PosedCage& cage, std::span<const PatchTile> patches, Arena& arena);
    /// Builds an igrid of faces of a triangle mesh.
    IGrid* build_triangles(const lod::PosedCage& cage, std::span<const std::uint32_t> faces, Arena& arena);

    /// The log2 of the largest number of quads with which a patch shares an igrid.
    static constexpr int kSmallExponent = 2;

    std::uint64_t micropolygons = 0;

private:
    void add_part(IGrid& grid, std::uint32_t number, const lod::LevelGrid& vertices);
    void add_vertices(const IGridPart& part, const lod::LevelGrid& vertices);
    void finish(IGrid& grid, bool blends, Arena& arena);
    void finish_hanging(IGrid& grid, Arena& arena);
    void finish_slab(IGrid& grid) const;
    Box3f box_of_block(const IGrid& grid, const LatticeBlock& block, int key) const noexcept;
    void finish_triangles(IGrid& grid, std::span<const std::uint32_t> faces, int leaves, Arena& arena);
    void cut_triangles(std::span<lod::BoxedFace> faces, int leaf, int leaves);

    lod::Dicer& dicer_;
    Arena diced_;
    std::vector<float> fine_[3], coarse_[3];  ///< at each key, one after the other
    std::vector<LatticeBlock> blocks_;
    std::vector<BlockHanging> block_hanging_;
    std::vector<lod::Hanging> hanging_;
    std::vector<std::uint32_t> hanging_quads_;
    // Scratch for the mesh igrid that is being built.
    struct TriangleBlock {
        int leaf;
        std::span<const lod::BoxedFace> faces;
    };
    std::vector<lod::BoxedFace> boxed_;  ///< numbered as in the list of faces
    std::vector<Vec3f> corners_;         ///< three per face, at each key, one after the other
    std::vector<TriangleBlock> triangle_blocks_;
};

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
