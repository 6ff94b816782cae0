#include "accel/memory_floor.h"

#include "accel/kd_tree.h"
#include "accel/vertex_values.h"
#include "lod/deformed_cage.h"

namespace occam::accel {
namespace {

constexpr std::size_t kGrids = 8;  // igrids that one ray may need at once

// The largest igrid holds a whole tile: both levels of its vertices, their normals and texture coordinates, its boxes, and
// the most floats that phase one keeps for both levels, at every 2^kCoarser-th of these vertices.
constexpr std::size_t kValueSide = (lod::TileRef::kMaxSide >> kCoarser) + 1;
constexpr std::size_t kBytesOfAGrid = sizeof(IGrid) +
                                      (lod::TileRef::kMaxSide + 1) * (lod::TileRef::kMaxSide + 1) *
                                          (2 * sizeof(Vec3f) + 2 * sizeof(Vec3f) + 2 * sizeof(Vec2f)) +
                                      128 * (BoxTree::kFloats / BoxTree::kGroup) * sizeof(float) +
                                      2 * kValueSide * kValueSide * lod::VertexShader::kMaxChannels * sizeof(float);

// An opened item takes its own memory, and entries in the lists of the nodes above and below a plane.
constexpr std::size_t kBytesOfAnItem = sizeof(Item) + sizeof(PlacedNode) + 4 * sizeof(ItemIndex);

}  // namespace

std::size_t memory_floor(const Scene& scene)
{
    const Contents contents = scene.contents();
    std::size_t largest = sizeof(lod::PosedCage) +
                          lod::ClusterTree::kLeafFaces * contents.largest_face * (sizeof(PatchInfo) + kBytesOfAnItem);
    if (contents.deformed_vertices > 0)
        largest += sizeof(lod::DeformedCage) + contents.deformed_vertices / 4;  // one pointer for each block of 32 vertices
    largest += contents.joints * sizeof(Mat4d);
    // The tables of a tree grow in pieces, and each needs at least one.
    constexpr std::size_t kPiece = ArenaVector<Item>::kPiece;
    constexpr std::size_t kTables = kPiece * (sizeof(Item) + sizeof(KdNode) + 2 * sizeof(KdLeaf));
    const std::size_t bytes = kTables + contents.widest * kBytesOfAnItem + largest + kGrids * kBytesOfAGrid;
    return (bytes + Arena::kChunkBytes - 1) / Arena::kChunkBytes * Arena::kChunkBytes;
}

}  // namespace occam::accel
