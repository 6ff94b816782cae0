#include "accel/memory_floor.h"

#include <algorithm>

#include "accel/bvh.h"
#include "accel/kd_tree.h"
#include "accel/phase_one.h"
#include "lod/deformed_cage.h"

namespace occam::accel {
namespace {

constexpr std::size_t kGrids = 8;  // igrids that one ray may need at once

// The largest igrid holds a whole tile: both levels of its vertices, their normals and texture coordinates, its boxes, and
// the most floats that phase one keeps for both levels, at every 2^kCoarser-th of these vertices. What moves is kept at
// each key.
constexpr std::size_t kValueSide = (lod::TileRef::kMaxSide >> kCoarser) + 1;
constexpr std::size_t kVerticesOfAGrid = (lod::TileRef::kMaxSide + 1) * (lod::TileRef::kMaxSide + 1);
constexpr std::size_t kStillBytesOfAGrid = sizeof(LatticeGrid) + sizeof(IGridPart) + kVerticesOfAGrid * 2 * sizeof(Vec2f) +
                                           2 * kValueSide * kValueSide * lod::VertexShader::kMaxChannels * sizeof(float);
constexpr std::size_t kMovingBytesOfAGrid = kVerticesOfAGrid * (2 * sizeof(Vec3f) + 2 * sizeof(Vec3f)) +
                                            128 * (BoxTree::kFloats / BoxTree::kGroup) * sizeof(float);

// A reference to a triangle of a mesh igrid has its place in a block, which may be two thirds full, and a share of the nodes
// above it.
constexpr std::size_t kStillBytesOfATriangle = 2 * sizeof(std::uint32_t);
constexpr std::size_t kMovingBytesOfATriangle = sizeof(TriangleBlock) * 3 / (2 * TriangleBlock::kTriangles) +
                                                sizeof(TriangleNode) / 20;

// An opened item takes its own memory, and entries in the lists of the nodes above and below a plane.
constexpr std::size_t kBytesOfAnItem = sizeof(Item) + sizeof(PlacedNode) + 4 * sizeof(ItemIndex);
/// What such a part has at each key: a box of its own, one of its patch, and a matrix.
constexpr std::size_t kBytesOfAKey = 2 * sizeof(Box3f) + sizeof(Mat4d);

/// keys   the number of keys of the scene's shutter, at each of which any cage may be posed; 1: nothing moves
std::size_t largest_cage(const Contents& contents, std::size_t keys)
{
    const std::size_t items = lod::ClusterTree::kLeafFaces * contents.largest_face;
    std::size_t posed = sizeof(lod::PosedCage) + contents.joints * sizeof(Mat4d);
    if (contents.deformed_vertices > 0)
        posed += sizeof(lod::DeformedCage) + contents.deformed_vertices / 4;  // one pointer for each block of 32 vertices
    // A tree that is dropped takes its derived points along. So that making them anew does not take most of the time, there
    // is as much room beside them.
    posed += 2 * contents.derived_points * sizeof(Vec3f);
    // A cluster has at least one face.
    if (keys > 1) posed += items * kBytesOfAKey + 2 * contents.written_faces * sizeof(Box3f);
    return items * (sizeof(PatchInfo) + kBytesOfAnItem) + keys * posed;
}

}  // namespace

std::size_t memory_floor(const Scene& scene)
{
    // The tables of a tree grow in pieces, and each needs at least one.
    constexpr std::size_t kPiece = ArenaVector<Item>::kPiece;
    constexpr std::size_t kTables = kPiece * (sizeof(Item) + sizeof(KdNode) + 2 * sizeof(KdLeaf));
    const auto keys = static_cast<std::size_t>(scene.shutter_segments()) + 1;
    const Contents contents = scene.contents();
    const std::size_t of_a_node = kBytesOfAnItem + (keys > 1 ? keys * kBytesOfAKey : 0);
    const std::size_t triangles = std::min<std::size_t>(scene.counts().mesh_triangles, lod::ClusterTree::kMeshFaces) *
                                  TriangleTree::kMostQuarters / 4;
    const std::size_t grids = kGrids * std::max(kStillBytesOfAGrid + keys * kMovingBytesOfAGrid,
                                                triangles * (kStillBytesOfATriangle + keys * kMovingBytesOfATriangle));
    const std::size_t bytes = kTables + (contents.widest + contents.levels) * of_a_node + largest_cage(contents, keys) +
                              grids;
    return (bytes + Arena::kChunkBytes - 1) / Arena::kChunkBytes * Arena::kChunkBytes;
}

}  // namespace occam::accel
