// A skinned or morphed cage as one node shows it, for one frame. Vertices are posed when they are first needed.
//
// Morph targets come first, then linear blend skinning (glTF 2.0, sec. 3.7.3: the node's own transform does not count). A
// position is a pure function of vertex and pose, in double and rounded once, so every caller gets the same bits.
//
// Space    from mesh axes to the dicing frame of a PosedCage.
// Memory   the arena of a tree: a matrix for each joint, and 12 bytes for each vertex, in blocks of kBlock, each when it is
//          first needed.
// Threads  position() poses vertices, so one thread at a time may call it: the owner of the tree, or the worker that holds
//          the lock of a shared tree.
#pragma once

#include "base/arena.h"
#include "lod/deformed_clusters.h"
#include "scenegraph/scene.h"

namespace occam::lod {

struct DeformCounters {
    std::uint64_t vertices = 0;  ///< vertices posed, in whole blocks
    double seconds = 0;
};

/// Holds what decides where the vertices of a cage are at one moment of the shutter.
struct CagePose {
    std::span<const Vec3f> positions;      ///< at rest, one for each vertex
    std::span<const float> morph_weights;  ///< one for each morph target
    bool is_skinned = false;
    std::span<const Mat4d> joints;  ///< base_from_mesh of each joint
    Mat4d node_from_skin{1};

    /// skin   null: morph targets alone
    /// key    of the scene's shutter; negative: the pose that the scene is in
    CagePose(const CageSlot& slot, const Node& node, const SkinSlot* skin, int key = -1) noexcept;
};

class DeformedCage {
public:
    /// frame_from_node   rows, as PosedCage has them
    DeformedCage(const CageSlot& slot, const CagePose& pose, const double (&frame_from_node)[3][4], Arena& arena,
                 DeformCounters& counters);

    Vec3f position(std::uint32_t v)
    {
        const Vec3f* block = blocks_[v / kBlock];
        if (!block)
            block = pose_block(v / kBlock);  // as (block ? block : ...)[v % kBlock], g++ 12 loses the index under ubsan
        return block[v % kBlock];
    }
    /// Returns the same without keeping it.
    Vec3f posed(std::uint32_t v) const noexcept;
    /// Returns the unit normal of a vertex of a cage that has normals: morphed, then mapped by the inverse transpose of the
    /// vertex's blended matrix. It is 0 if that leaves no direction.
    Vec3f normal(std::uint32_t v) const noexcept;
    /// Returns the bounds of the vertices that `of` describes, in the dicing frame.
    Box3d box(const DeformBounds& of) const noexcept;
    bool is_mirrored() const noexcept { return is_mirrored_; }
    bool is_skinned() const noexcept { return joints_ != nullptr; }

private:
    static constexpr std::uint32_t kBlock = 32;

    const Vec3f* pose_block(std::uint32_t block);
    /// Returns where the skin and the frame put a vertex that morph targets have moved to `p`.
    Vec3f skinned(std::uint32_t v, Vec3d p) const noexcept;
    const Mat4d& joint(std::size_t j) const noexcept { return j < joint_count_ ? joints_[j] : frame_from_mesh_; }

    const Cage& cage_;
    std::span<const Vec3f> positions_;  ///< at rest
    std::span<const float> weights_;    ///< one for each morph target
    Mat4d frame_from_mesh_;             ///< used without joints
    const Mat4d* joints_ = nullptr;     ///< frame_from_mesh of each joint; null: not skinned
    std::size_t joint_count_ = 0;
    bool is_mirrored_ = false;
    Vec3f** blocks_;
    Arena* arena_;
    DeformCounters* counters_;
};

}  // namespace occam::lod
