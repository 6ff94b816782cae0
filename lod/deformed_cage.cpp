#include "lod/deformed_cage.h"

#include <algorithm>

#include "base/matrix.h"
#include "base/stopwatch.h"
#include "scenegraph/posed_faces.h"

namespace occam::lod {
namespace {

// Maps a normal by the cofactors of m, which are its inverse transpose times its determinant. The sign of the determinant is
// removed, so that the normal points outside if m mirrors, too.
Vec3d turned_normal(const Mat3d& m, Vec3d n) noexcept
{
    const Vec3d v = glm::cross(m[1], m[2]) * n.x + glm::cross(m[2], m[0]) * n.y + glm::cross(m[0], m[1]) * n.z;
    return glm::determinant(m) < 0 ? -v : v;
}

}  // namespace

CagePose::CagePose(const CageSlot& slot, const Node& node, const SkinSlot* skin, int key) noexcept
    : positions(slot.cage.positions),
      morph_weights(node.morph_weights),
      is_skinned(skin && slot.cage.skin.sets > 0),
      node_from_skin(node.node_from_skin)
{
    if (is_skinned) joints = skin->mesh_poses;
    if (key >= 0) {
        const auto k = static_cast<std::size_t>(key);
        if (!slot.key_positions.empty()) positions = slot.key_positions[k];
        if (!node.keys.empty()) {
            morph_weights = node.keys[k].morph_weights;
            node_from_skin = node.keys[k].node_from_skin;
        }
        if (is_skinned && !skin->key_poses.empty()) joints = skin->key_poses[k];
    }
    if (morph_weights.empty()) morph_weights = slot.cage.morph_weights;
}

DeformedCage::DeformedCage(const CageSlot& slot, const CagePose& pose, const double (&rows)[3][4], Arena& arena,
                           DeformCounters& counters)
    : cage_(slot.cage), positions_(pose.positions), weights_(pose.morph_weights), arena_(&arena), counters_(&counters)
{
    for (int c = 0; c < 4; ++c) frame_from_mesh_[c] = Vec4d(rows[0][c], rows[1][c], rows[2][c], c == 3 ? 1 : 0);
    if (pose.is_skinned) {
        frame_from_mesh_ = frame_from_mesh_ * pose.node_from_skin;
        joint_count_ = pose.joints.size();
        const std::span<Mat4d> joints = arena.make_array<Mat4d>(joint_count_);
        // Joints that move no vertex have no part in this. Vertices that no face has may name others.
        if (!slot.unused_vertices.empty()) std::ranges::fill(joints, frame_from_mesh_);
        int mirrored = 0;
        for (const JointBox& used : slot.deform[0].joints) {
            if (used.joint < joint_count_) joints[used.joint] = frame_from_mesh_ * pose.joints[used.joint];
            mirrored += mirrors(Mat3d(used.joint < joint_count_ ? joints[used.joint] : frame_from_mesh_)) ? 1 : -1;
        }
        joints_ = joints.data();
        is_mirrored_ = mirrored > 0;
    } else {
        is_mirrored_ = mirrors(Mat3d(frame_from_mesh_));
    }
    const std::size_t blocks = (cage_.positions.size() + kBlock - 1) / kBlock;
    blocks_ = arena.make_array<Vec3f*>(blocks).data();
    std::fill_n(blocks_, blocks, nullptr);
}

Vec3f DeformedCage::posed(std::uint32_t v) const noexcept { return skinned(v, morphed(cage_, positions_, weights_, v)); }

Vec3f DeformedCage::skinned(std::uint32_t v, Vec3d p) const noexcept
{
    if (!joints_) return Vec3f(transform_point(frame_from_mesh_, p));
    Vec3d sum(0);
    double total = 0;
    for (int set = 0; set < cage_.skin.sets; ++set) {
        const std::size_t at = std::size_t(set) * cage_.positions.size() + v;
        for (int k = 0; k < 4; ++k) {
            const double w = double(cage_.skin.weights[at][k]);
            if (!(w > 0)) continue;
            sum += transform_point(joint(cage_.skin.joints[at][k]), p) * w;
            total += w;
        }
    }
    // The weights are divided by their sum, so that they are those of a mean, as deformed_box() requires.
    return Vec3f(sum / total);
}

const Vec3f* DeformedCage::pose_block(std::uint32_t block)
{
    const Stopwatch watch(counters_->seconds);
    const auto vertices = static_cast<std::uint32_t>(cage_.positions.size());
    const std::uint32_t first = block * kBlock, end = std::min(first + kBlock, vertices);
    Vec3f* out = arena_->make_array<Vec3f>(kBlock).data();
    // Target by target, since the offsets of one lie side by side. The sums are those of morphed(), in the same order.
    Vec3d moved[kBlock];
    for (std::uint32_t v = first; v < end; ++v) moved[v - first] = Vec3d(positions_[v]);
    for (std::size_t k = 0; k < std::min(weights_.size(), cage_.morph_targets.size()); ++k) {
        const std::vector<Vec3f>& offsets = cage_.morph_targets[k].positions;
        if (weights_[k] == 0 || offsets.empty()) continue;
        for (std::uint32_t v = first; v < end; ++v) moved[v - first] += Vec3d(offsets[v]) * double(weights_[k]);
    }
    for (std::uint32_t v = first; v < end; ++v) out[v - first] = skinned(v, moved[v - first]);
    blocks_[block] = out;
    counters_->vertices += end - first;
    return out;
}

Vec3f DeformedCage::normal(std::uint32_t v) const noexcept
{
    Vec3d n(cage_.normals[v]);
    for (std::size_t k = 0; k < std::min(weights_.size(), cage_.morph_targets.size()); ++k)
        if (weights_[k] != 0 && !cage_.morph_targets[k].normals.empty())
            n += Vec3d(cage_.morph_targets[k].normals[v]) * double(weights_[k]);
    Mat3d blended(frame_from_mesh_);
    if (joints_) {
        blended = Mat3d(0);
        for (int set = 0; set < cage_.skin.sets; ++set) {
            const std::size_t at = std::size_t(set) * cage_.positions.size() + v;
            for (int k = 0; k < 4; ++k)
                if (cage_.skin.weights[at][k] > 0)
                    blended += Mat3d(joint(cage_.skin.joints[at][k])) * double(cage_.skin.weights[at][k]);
        }
    }
    n = turned_normal(blended, n);
    const double length = glm::length(n);
    return length > 0 ? Vec3f(n / length) : Vec3f(0);
}

Box3d DeformedCage::box(const DeformBounds& of) const noexcept
{
    const DeformBounds bounds = joints_ ? of : DeformBounds{of.rest, {}, of.offsets};
    return deformed_box(bounds, weights_, frame_from_mesh_, [&](std::size_t j) { return joint(j); });
}

}  // namespace occam::lod
