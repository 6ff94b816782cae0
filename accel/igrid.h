// A tile of a patch, small patches of a cluster, or the triangles of a cluster, ready to be met by rays ("igrid", Djeu et
// al. 2011, sec. 5.2.3).
//
// A *lattice* igrid has vertices in rows and is cut into blocks of up to 4 x 2 quads; a *mesh* igrid has triangles, up to
// eight a block, parted into blocks by the surface area heuristic (lod/face_split.h). Over the blocks lies a complete binary
// tree of boxes without pointers (Hou et al. 2010, sec. 3: halving the longer parametric side is within 20 % of greedy SAH);
// children of node n are 2n + 1 and 2n + 2, and the leaves are consecutive, so that a single ray can test eight of them at
// once.
//
// A lattice serves a pair of levels: each vertex has a fine and a coarse position, and each ray blends them for itself
// (lod/ray_levels.h). T-vertices have neither: they are middles of blended edge vertices.
//
// Space    the cage's dicing frame.   Memory  in an arena; its tree borrows it.   Threads  read only but for `visit` and
// what phase
//          one fills in.
#pragma once

#include <cfloat>
#include <cstdint>
#include <span>

#include "lod/dicer.h"
#include "lod/face_split.h"
#include "lod/level_grid.h"

namespace occam::accel {

/// Pairs of levels, both ends included.
struct PairRange {
    int finest = 0, coarsest = 0;
    bool has(int pair) const noexcept { return finest <= pair && pair <= coarsest; }
    bool is_empty() const noexcept { return finest > coarsest; }
};

/// A quad of a tile: its lower left vertex; and which triangle: 0 (v00, v10, v11), 1 (v00, v11, v01).
struct QuadRef {
    std::uint16_t i, j;
    std::uint8_t triangle;
};

/// Boxes of a complete binary tree without pointers, in groups of eight: eight lo.x, eight lo.y, ..., eight hi.z, so that
/// what is read together is together. The leaves come first, then a place to spare and the nodes above them from the root
/// on: so the eight nodes of the fourth row are a group, too.
struct BoxTree {
    static constexpr int kGroup = 8, kFloats = 6 * kGroup;

    int leaves = 0;  ///< a power of two
    float* data = nullptr;

    static constexpr int kFourthRow = 7;  ///< its first node

    int first_leaf() const noexcept { return leaves - 1; }
    int node_count() const noexcept { return 2 * leaves - 1; }
    int group_count() const noexcept { return (2 * leaves + kGroup - 1) / kGroup; }
    /// lo.x of a node; the next coordinate is kGroup further. Of consecutive leaves from a multiple of eight on: side by
    /// side.
    float* at(int node) const noexcept
    {
        const int place = node < first_leaf() ? leaves + 1 + node : node - first_leaf();
        return data + offset(static_cast<std::size_t>(place));
    }
    /// Of a box's lo.x in groups.
    static constexpr std::size_t offset(std::size_t place) noexcept { return place / kGroup * kFloats + place % kGroup; }
    Box3f bounds() const noexcept { return {{lo(0, 0), lo(0, 1), lo(0, 2)}, {hi(0, 0), hi(0, 1), hi(0, 2)}}; }
    float& lo(int node, int axis) const noexcept { return at(node)[axis * kGroup]; }
    float& hi(int node, int axis) const noexcept { return at(node)[(axis + 3) * kGroup]; }
};

/// What lies between two parallel planes: lo <= dot(normal, p) <= hi. By default everything.
struct Slab {
    Vec3f normal{0};  ///< unit, or 0
    float lo = -FLT_MAX, hi = FLT_MAX;
};

/// Where an igrid lies: in both.
struct GridBounds {
    Box3f box;
    Slab slab;
};

/// One patch of a lattice: a tile of it, or all of a small one.
struct IGridPart {
    lod::TileRef tile;
    lod::GridAttributes attributes;  ///< made when a hit first asks, as is:
    const Material* material = nullptr;
    bool is_shaded = false;  ///< published, as are:
    const float* values[2] =
        {};  ///< VertexShader's, of the fine and of the coarse level; null: not made (accel/vertex_values.h)
    std::int8_t channels = -1;      ///< floats of these a vertex; below 0: nobody has asked yet
    bool is_transposed = false;     ///< rows run along v
    bool is_halved = false;         ///< in the pair's coarser level the patch has half as many rows and columns
    std::int8_t coarse_filter = 0;  ///< PatchRates::filter of that level
    std::uint32_t first = 0;        ///< vertex
    std::uint32_t width = 0;        ///< vertices of a row

    /// Of the pair's coarser level, sides aside.
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

/// Quads side by side in two rows, or one.
struct LatticeBlock {
    std::uint32_t first = 0;             ///< vertex: lower left
    std::uint16_t stride = 0;            ///< vertices of a row
    std::uint8_t columns = 0, rows = 0;  ///< quads: 1 to 4, 1 or 2
    std::uint8_t fast = 0, slow = 0;     ///< its first quad in the part, along a row and across
    bool is_transposed = false;
    std::uint16_t part = 0;
    std::uint16_t hanging_count = 0;
    std::uint32_t hanging = 0;  ///< of its T-vertices: in IGrid::block_hanging

    static constexpr int kColumns = 5, kRows = 3;  ///< vertices, at most
};

/// A T-vertex of a block.
struct BlockHanging {
    std::uint32_t hanging = 0;  ///< in IGrid::hanging
    std::uint8_t column = 0, row = 0;
};

/// A mailbox: the packet that met an igrid last, and which of its rays.
struct GridVisit {
    std::uint64_t packet = 0;
    std::uint32_t lanes = 0;
};

struct IGrid {
    static constexpr int kBlock = 8;  ///< quads or triangles a block

    // What every visit reads comes first, in few cache lines.
    GridVisit visit;  ///< of the one worker whose tree it is; workers that share a tree have theirs
    bool is_lattice = false;
    std::uint8_t seen_by = RayKind::All;
    int hanging_blocks = 0;
    PairRange pairs;  ///< that meet it
    const lod::PosedCage* cage = nullptr;
    BoxTree boxes;  ///< one leaf a block; empty boxes pad to a power of two
    Slab slab;      ///< around all vertices, fine and coarse

    // Lattice
    const float* fine[3] = {};
    const float* coarse[3] = {};  ///< the same arrays, if nothing blends
    const LatticeBlock* blocks = nullptr;
    BoxTree hanging_boxes;
    const BlockHanging* block_hanging = nullptr;
    std::span<const lod::Hanging> hanging;  ///< all that have a triangle here; padded with copies to whole blocks of eight
    const std::uint32_t* hanging_quads = nullptr;  ///< of each: the micropolygon that it stands for in ids
    std::span<IGridPart> parts;                    ///< empty for a mesh
    int level = 0;                                 ///< of the fine positions

    // Mesh
    const float* corners[9] = {};             ///< a.x a.y a.z b.x .. c.z, padded with copies to whole blocks
    const std::uint32_t* ids = nullptr;       ///< face
    const std::uint16_t* block_at = nullptr;  ///< the block of each leaf of `boxes`; a leaf without one has an empty box

    bool blends() const noexcept { return coarse[0] != fine[0]; }
    Vec3f fine_at(std::uint32_t v) const noexcept { return {fine[0][v], fine[1][v], fine[2][v]}; }
    Vec3f coarse_at(std::uint32_t v) const noexcept { return {coarse[0][v], coarse[1][v], coarse[2][v]}; }
};

/// A micropolygon by number: the triangles of T-vertices have the top bit.
inline constexpr std::uint32_t kCloserBit = 0x80000000u;

/// Builds igrids. Scratch is reused; results are in the arena.
class IGridBuilder {
public:
    explicit IGridBuilder(lod::Dicer& dicer) : dicer_(dicer) {}

    struct Part {
        lod::TileRef tile;
        lod::PatchRates coarser;  ///< the patch's rates at the pair's coarser level
    };

    IGrid* build_tile(const lod::PosedCage& cage, const Part& tile, Arena& arena);
    /// Small patches of a cluster: each a whole patch of at most 2^kSmallExponent quads.
    IGrid* build_patches(const lod::PosedCage& cage, std::span<const Part> patches, Arena& arena);
    /// Faces of a triangle mesh.
    IGrid* build_triangles(const lod::PosedCage& cage, std::span<const std::uint32_t> faces, Arena& arena);

    /// log2 of the quads up to which a patch shares an igrid.
    static constexpr int kSmallExponent = 2;

    std::uint64_t micropolygons = 0;

private:
    void add_part(IGrid& grid, std::uint32_t number, const lod::LevelGrid& vertices);
    void finish(IGrid& grid, bool blends, Arena& arena);
    void finish_hanging(IGrid& grid, Arena& arena);
    void finish_slab(IGrid& grid) const;
    void cut_triangles(std::span<lod::BoxedFace> faces, int leaf, int leaves);

    lod::Dicer& dicer_;
    Arena diced_;
    std::vector<float> fine_[3], coarse_[3];
    std::vector<LatticeBlock> blocks_;
    std::vector<BlockHanging> block_hanging_;
    std::vector<lod::Hanging> hanging_;
    std::vector<std::uint32_t> hanging_quads_;
    // Of the mesh that is being built.
    struct TriangleBlock {
        int leaf;
        std::span<const lod::BoxedFace> faces;
    };
    std::vector<lod::BoxedFace> boxed_;  ///< numbered as in the list of faces
    std::vector<Vec3f> corners_;         ///< three a face
    std::vector<TriangleBlock> triangle_blocks_;
};

/// Part, quad and triangle of a lattice's ids.
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
