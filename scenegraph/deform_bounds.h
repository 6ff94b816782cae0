// Bounds of a deformed cage, computed from what deforms it without posing a vertex.
//
// A skinned vertex is a weighted mean of its images under its joints, and no weight is negative. So it lies in the union of
// the images of each joint's box, which bounds the rest vertices that the joint moves. A morph target adds at most its
// weight times the box of its offsets.
//
// Space    boxes are in mesh axes, those of the cage's rest positions.
// Threads  plain data, const once it is made.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenegraph/cage.h"

namespace occam {

/// Bounds the rest vertices that a joint moves.
struct JointBox {
    std::uint16_t joint = 0;
    Box3f box;
};

/// Bounds some of a cage's vertices; the spans point into the table's arrays.
struct DeformBounds {
    Box3f rest;
    std::span<const JointBox> joints;  ///< empty: not skinned
    std::span<const Box3f> offsets;    ///< one for each morph target; empty boxes where it moves none of the vertices
};

/// Returns the box of all offsets by which morph targets move a vertex at these weights; the point 0 if there are none.
Box3d morph_extent(std::span<const Box3f> offsets, std::span<const float> weights) noexcept;

/// Returns a box that holds every vertex of `of`, morphed and then posed by its joints, or by `otherwise` without a skin.
/// joint_pose(j)   returns space_from_mesh of joint j
template <class JointPose>
Box3d deformed_box(const DeformBounds& of, std::span<const float> weights, const Mat4d& otherwise,
                   JointPose&& joint_pose) noexcept
{
    const Box3d moved = morph_extent(of.offsets, weights);
    const auto grown = [&](const Box3f& box) { return Box3d{Vec3d(box.lo) + moved.lo, Vec3d(box.hi) + moved.hi}; };
    if (of.joints.empty()) return of.rest.is_empty() ? Box3d() : transform_box(otherwise, grown(of.rest));
    Box3d box;
    for (const JointBox& joint : of.joints) box.add(transform_box(joint_pose(joint.joint), grown(joint.box)));
    return box;
}

/// Collects the bounds of a cage's parts, one after the other, in shared arrays.
class DeformBoundsTable {
public:
    /// Adds the bounds of the given vertices. The number of the new part is the count of parts before it.
    void add(const Cage& cage, std::span<const std::uint32_t> vertices);
    /// Adds the bounds of all the cage's vertices but some, which are in ascending order.
    void add_all(const Cage& cage, std::span<const std::uint32_t> without);
    /// Adds the union of the bounds of two parts.
    void add_union(std::size_t a, std::size_t b);

    DeformBounds operator[](std::size_t part) const noexcept;
    std::size_t size() const noexcept { return parts_.size(); }

private:
    struct PartRecord {
        Box3f rest;
        std::uint32_t first_joint = 0, joint_count = 0, first_offset = 0;
    };
    void add_vertex(const Cage& cage, std::uint32_t v);
    void begin(const Cage& cage);
    void add_to_joint(std::uint16_t joint, const Box3f& box);
    void finish();

    std::vector<PartRecord> parts_;
    std::vector<JointBox> joints_;
    std::vector<Box3f> offsets_;
    std::size_t targets_ = 0;
    std::vector<Box3f> scratch_;          ///< indexed by joint
    std::vector<std::uint16_t> touched_;  ///< joints whose box there is not empty
};

}  // namespace occam
