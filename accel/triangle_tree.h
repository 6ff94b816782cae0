// A tree over the triangles of a mesh igrid: boxes eight at a time, and triangles in blocks of up to eight.
//
// A node holds the boxes of up to eight parts, which are nodes or blocks of triangles. The surface area heuristic divides
// the triangles (lod/face_split.h), the largest part first, until a node is full. Where the boxes of two parts overlap much,
// triangles are cut at a plane instead (accel/spatial_split.h). Such a triangle stands whole in several blocks, each of
// which is bounded by the box of a part of it.
//
// If the igrid moves, nodes and blocks are stored for each key of the motion, one key after the other; the tree is the same
// at all keys.
//
// Space    The cage's dicing frame.
// Memory   An arena.
// Threads  Read only.
#pragma once

#include <cstdint>
#include <list>
#include <span>
#include <vector>

#include "accel/spatial_split.h"
#include "base/arena.h"
#include "base/simd.h"
#include "lod/face_split.h"

namespace occam::accel {

/// Holds eight boxes (eight lo.x, eight lo.y, ..., eight hi.z) and what they contain. A spare box is empty.
struct alignas(Arena::kAlign) TriangleNode {
    static constexpr int kWidth = 8;
    static constexpr std::uint32_t kIsBlock = 0x80000000u;

    float boxes[6 * kWidth];
    /// The index of a node, or kIsBlock and the index of a block.
    std::uint32_t children[kWidth];

    static bool is_block(std::uint32_t child) noexcept { return (child & kIsBlock) != 0; }
    static std::uint32_t block_of(std::uint32_t child) noexcept { return child & ~kIsBlock; }
};

/// Holds up to eight triangles: the coordinates a.x, a.y, a.z, b.x, ... of each. Those of a spare triangle are NaN, so that
/// no ray hits it.
struct alignas(Arena::kAlign) TriangleBlock {
    static constexpr int kTriangles = 8;
    float corners[9][kTriangles];
};

struct TriangleTree {
    /// The number of references to triangles in blocks is at most this many quarters of the number of triangles.
    static constexpr std::size_t kMostQuarters = 6;
    /// A depth from which on parts are halved by number. Halving needs few more levels, since an igrid has few triangles.
    static constexpr int kMostAreaDepth = 16, kMostDepth = kMostAreaDepth + 11;

    std::uint32_t node_count = 0, block_count = 0;  ///< at one key
    const TriangleNode* nodes = nullptr;            ///< the first one is the root
    const TriangleBlock* blocks = nullptr;
    /// The face of each triangle; several may have the same. A triangle's place is eight times its block and its number in
    /// the block. Spare triangles repeat the face before them.
    const std::uint32_t* faces = nullptr;

    /// Return the number of floats from a value to the same one at the next key.
    std::ptrdiff_t node_floats_of_a_key() const noexcept { return floats_of(node_count, sizeof(TriangleNode)); }
    std::ptrdiff_t block_floats_of_a_key() const noexcept { return floats_of(block_count, sizeof(TriangleBlock)); }
    Vec3f corner(std::uint32_t place, int corner, int key = 0) const noexcept
    {
        const TriangleBlock& block = blocks[std::size_t(key) * block_count + place / TriangleBlock::kTriangles];
        const float(*at)[TriangleBlock::kTriangles] = &block.corners[corner * 3];
        const std::uint32_t i = place % TriangleBlock::kTriangles;
        return {at[0][i], at[1][i], at[2][i]};
    }
    /// Returns whether a place holds no triangle of its own.
    bool is_spare(std::uint32_t place) const noexcept
    {
        return place % TriangleBlock::kTriangles != 0 && faces[place] == faces[place - 1];
    }
    /// Returns the box of everything at a key.
    Box3f bounds(int key) const noexcept;

private:
    static std::ptrdiff_t floats_of(std::uint32_t count, std::size_t bytes) noexcept
    {
        return static_cast<std::ptrdiff_t>(count * (bytes / sizeof(float)));
    }
};

/// Builds such trees. The scratch memory is reused.
class TriangleTreeBuilder {
public:
    /// Builds a tree in the arena.
    /// faces     the face of each triangle
    /// corners   three for each triangle, at each key, one key after the other
    TriangleTree build(std::span<const std::uint32_t> faces, std::span<const Vec3f> corners, int keys, Arena& arena);

    bool splits_in_space = true;  ///< for benchmarks: whether triangles may be cut

private:
    struct Part;
    struct Node {
        std::uint32_t children[TriangleNode::kWidth];
        int count;
    };
    /// A range of `references_`.
    struct Block {
        std::uint32_t first, count;
    };
    /// Returns the triangles of a block, or their parts. They are numbered as in the list of faces.
    std::span<const lod::BoxedFace> of(const Block& block) const noexcept
    {
        return std::span(references_).subspan(block.first, block.count);
    }
    void set_middle(std::span<const Vec3f> corners, int keys);
    /// Splits a part in two, if this pays or the part is too large for a block; returns whether it has.
    /// made   receives the lists of parts that a split in space makes
    bool split(Part& part, Part& other, int depth, std::list<SpatialParts>& made);
    std::uint32_t add_node(std::span<lod::BoxedFace> faces, int depth);
    const Vec3f* corners_at(std::uint32_t triangle, std::size_t key) const noexcept
    {
        return &corners_.at_keys[key * corners_.middle.size() + 3 * std::size_t(triangle)];
    }
    /// Adds the box of a triangle, or of a part of it, to a block's box at each key.
    void add_box(const lod::BoxedFace& reference, std::span<Box3f> boxes) const;
    void box_block(const Block& block, std::span<Box3f> boxes) const;
    void set_boxes(const TriangleTree& tree, std::span<TriangleNode> nodes, int keys) const;

    std::vector<Node> nodes_;
    std::vector<Block> blocks_;
    std::vector<lod::BoxedFace> references_;  ///< block after block
    std::vector<lod::BoxedFace> boxed_;       ///< all triangles, reordered
    std::vector<Vec3f> middle_;
    TriangleCorners corners_;
    std::size_t spare_ = 0;  ///< the number of triangles that may still be referred to once more
    float overlap_ = 0;      ///< area of the overlap of two parts from which on they may be split in space
};

}  // namespace occam::accel
