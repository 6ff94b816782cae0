#include "accel/memory_floor.h"

#include "accel/bvh.h"
#include "accel/kd_tree.h"
#include "accel/placement.h"
#include "accel/vertex_values.h"
#include "lod/deformed_cage.h"

namespace occam::accel {
namespace {

constexpr std::size_t kGrids = 8;  // igrids that one ray may need at once

// The largest igrid holds a whole tile: both levels of its vertices, their normals and texture coordinates, its boxes, and
// the most floats that phase one keeps for both levels, at every 2^kCoarser-th of these vertices. What moves is kept at
// each key.
constexpr std::size_t kValueSide = (lod::TileRef::kMaxSide >> kCoarser) + 1;
constexpr std::size_t kVerticesOfAGrid = (lod::TileRef::kMaxSide + 1) * (lod::TileRef::kMaxSide + 1);
constexpr std::size_t kStillBytesOfAGrid = sizeof(IGrid) + kVerticesOfAGrid * 2 * sizeof(Vec2f) +
                                           2 * kValueSide * kValueSide * lod::VertexShader::kMaxChannels * sizeof(float);
constexpr std::size_t kMovingBytesOfAGrid = kVerticesOfAGrid * (2 * sizeof(Vec3f) + 2 * sizeof(Vec3f)) +
                                            128 * (BoxTree::kFloats / BoxTree::kGroup) * sizeof(float);

// An opened item takes its own memory, and entries in the lists of the nodes above and below a plane.
constexpr std::size_t kBytesOfAnItem = sizeof(Item) + sizeof(PlacedNode) + 4 * sizeof(ItemIndex);
/// What such a part has at each key: a box of its own, one of its patch, and a matrix.
constexpr std::size_t kBytesOfAKey = 2 * sizeof(Box3f) + sizeof(Mat4d);

/// keys   at which the cage is posed
std::size_t bytes_of(const CageSlot& slot, const SkinSlot* skin, std::size_t keys)
{
    const Cage& cage = slot.cage;
    const std::size_t items = lod::ClusterTree::kLeafFaces * slot.largest_face;
    std::size_t posed = sizeof(lod::PosedCage) + items * kBytesOfAKey;
    if (slot.is_deformed())
        posed += sizeof(lod::DeformedCage) + cage.positions.size() / 4;  // one pointer for each block of 32 vertices
    if (skin) posed += skin->skin.joints.size() * sizeof(Mat4d);
    // A cluster has at least one face.
    if (!slot.key_positions.empty()) posed += 2 * cage.face_count() * sizeof(Box3f);
    const std::size_t still = items * (sizeof(PatchInfo) + kBytesOfAnItem);
    return keys == 1 ? still + posed - items * kBytesOfAKey : still + keys * posed;
}

}  // namespace

std::size_t memory_floor(const Scene& scene)
{
    const auto keys = static_cast<std::size_t>(scene.shutter_segments()) + 1;
    std::size_t widest = 0, largest = 0;
    for_each_placement(scene, [&](const Node& node, std::span<const Mat4d>) {
        widest = std::max(widest, node.children.size() + node.cages.size() + 1);
        for (const CageId id : node.cages)
            if (const CageSlot* slot = scene.find(id))
                largest = std::max(largest, bytes_of(*slot, scene.find(node.skin), keys));
    });
    // The tables of a tree grow in pieces, and each needs at least one.
    constexpr std::size_t kPiece = ArenaVector<Item>::kPiece;
    constexpr std::size_t kTables = kPiece * (sizeof(Item) + sizeof(KdNode) + 2 * sizeof(KdLeaf));
    const std::size_t of_a_node = kBytesOfAnItem + (keys > 1 ? keys * kBytesOfAKey : 0);
    const std::size_t grids = kGrids * (kStillBytesOfAGrid + keys * kMovingBytesOfAGrid);
    const std::size_t bytes = kTables + widest * of_a_node + largest + grids;
    return (bytes + Arena::kChunkBytes - 1) / Arena::kChunkBytes * Arena::kChunkBytes;
}

}  // namespace occam::accel
