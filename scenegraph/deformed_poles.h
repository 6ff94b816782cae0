// Bounds the lengths of the edges at poles where morph targets and joints deform a cage, without posing a vertex.
//
// Let w be the weights of a skin, whose sum is 1, and M the maps of its joints, with linear parts A. The edge from vertex a
// to vertex b becomes the sum of w_aj A_j (a - b) over all joints j, a mean of images of the edge, and of (w_aj - w_bj) M_j
// b. These differences of weights add up to 0, so M_j - M_r may stand for M_j there, where r is the joint that moves the
// face most. Of n joints beside r, none adds more than its largest difference of weights times (M_j - M_r) b, and all add no
// more than n times as much as the one that adds most. A morph target lengthens an edge by at most its weight times the edge
// that its offsets make.
//
// Space    lengths in the axes of the cage, and of what its joints' maps lead to.
// Threads  plain data, const once it is made.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/box.h"
#include "base/matrix.h"
#include "scenegraph/cage.h"
#include "scenegraph/poles.h"

namespace occam {

class DeformedPoles {
public:
    DeformedPoles() = default;
    DeformedPoles(const Cage& cage, const PoleFaces& faces);

    /// Returns lengths that the edges at the poles of a morphed cage do not exceed.
    /// rest   their lengths at rest
    Poles morphed(Poles rest, std::span<const float> weights) const noexcept;
    /// Returns lengths that the edges at the poles of a skinned cage do not exceed.
    /// weights   of morph targets
    /// moved     the box of all offsets by which they move a vertex (morph_extent())
    /// joint_pose(j)   returns the map of joint j
    template <class JointPose>
    Poles skinned(std::span<const float> weights, const Box3d& moved, JointPose&& joint_pose) const
    {
        const Poles longer = morphed({}, weights);
        Poles longest, beside;
        for (const OfJoint& of : joints_) {
            Poles edges = of.longest;
            edges.lengthen(longer);
            longest.add(edges.scaled(largest_stretch(Mat3d(joint_pose(of.joint)))));
        }
        for (const Beside& of : beside_) {
            const Mat4d apart = joint_pose(of.joint) - joint_pose(of.main);
            double farthest = 0;
            for (int corner = 0; corner < 8; ++corner) {
                Vec3d p;
                for (int a = 0; a < 3; ++a)
                    p[a] = (corner >> a & 1) != 0 ? double(of.box.hi[a]) + moved.hi[a] : double(of.box.lo[a]) + moved.lo[a];
                farthest = std::max(farthest, glm::length(Vec3d(apart * Vec4d(p, 1))));
            }
            beside.add(of.share.scaled(farthest));
        }
        longest.lengthen(beside);
        return longest;
    }

private:
    /// The faces at poles that a joint moves.
    struct OfJoint {
        std::uint16_t joint;
        Poles longest;  ///< their longest edges at rest
    };
    /// The faces at poles that a joint moves beside another one, which moves them most, and not all of their corners alike.
    struct Beside {
        std::uint16_t main, joint;
        Poles share;  ///< what (M_j - M_r) b counts by, for each class of poles
        Box3f box;    ///< of their vertices at rest
    };
    class Builder;

    std::vector<Poles> targets_;  ///< the longest edges that the offsets of each morph target make
    std::vector<OfJoint> joints_;
    std::vector<Beside> beside_;
};

}  // namespace occam
