// Motions of cages while a shutter is open, for tests of motion blur, and cages diced at the keys of such a motion.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lod/cage_motion.h"
#include "lod/dicer.h"

namespace occam::test {

/// Return the matrices of a translation and of a scaling along the axes.
Mat4d moved_by(Vec3d by);
Mat4d scaled_by(Vec3d by);

/// Tells how a cage of about two units moves. Null functions change nothing.
struct Motion {
    std::string name;
    int segments = 1;
    std::function<Mat4d(double tau)> matrix;           ///< of the node
    std::function<Vec3f(Vec3f p, double tau)> vertex;  ///< rewrites the vertices
    std::function<Mat4d(double tau)> upper_joint;      ///< skins the cage: vertices follow it by as much as they are up
    std::function<float(double tau)> morph;            ///< weight of a morph target that swells the cage
};

/// Returns motions of every kind: translating, rotating, scaling, shearing, bending, collapsing, inverting, skinned,
/// morphed, several at a time, and as fast as a jump.
std::vector<Motion> motions();

/// Adds the cage below the root, placed by `place` after its motion, and records the motion as the scene's shutter.
NodeId add_moving(Scene& scene, const Cage& cage, const Motion& motion, const Mat4d& place = Mat4d(1));

/// Holds the triangles of a cage at one level, at each key of its motion.
class DicedMotion {
public:
    /// The cage is placed as the scene places it, at all keys of the scene's shutter.
    DicedMotion(const Scene& scene, NodeId node, int level);

    /// Returns the corners of all triangles at a moment, interpolated in double; in world axes.
    std::vector<Vec3d> corners_at(double tau) const;

private:
    int segments_ = 0;
    std::vector<std::vector<Vec3d>> keys_;
};

}  // namespace occam::test
