// Clips, skins, and how they pose nodes.
//
// A clip says which transforms and morph weights its nodes have at a given moment; Scene::pose() writes them into the nodes.
// This file only describes skins and morph targets; lod/deformed_cage.h applies them to vertices.
//
// Space    each value is in the axes of its node's parent, as in Trs.
// Time     seconds on the clip's own axis.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scenegraph/ids.h"

namespace occam {

/// The transform from a node to its parent, split into the parts that clips animate. The quaternion is (x, y, z, w) and
/// unit.
struct Trs {
    Vec3d translation{0};
    Vec4d rotation{0, 0, 0, 1};
    Vec3d scale{1};
    Mat4d matrix() const noexcept;
};

/// Returns the transform of an affine matrix, whose shear is left out: translation, the lengths of its axes, and the
/// rotation of its first two axes, the first of which is turned round if the matrix mirrors.
Trs decomposed(const Mat4d& parent_from_node) noexcept;

/// One animated property of one node (glTF 2.0, animation.channel and its sampler).
struct Channel {
    enum class Path : unsigned char { Translation, Rotation, Scale, Weights };
    enum class Interpolation : unsigned char { Step, Linear, CubicSpline };
    NodeId target{};
    Path path = Path::Translation;
    Interpolation interpolation = Interpolation::Linear;
    std::vector<float> times{};   ///< seconds, strictly increasing; none: the channel changes nothing
    std::vector<float> values{};  ///< `width` floats a key; CubicSpline: in-tangent, value and out-tangent a key
    int width = 3;
};
struct Clip {
    std::string name{};
    std::vector<Channel> channels{};
};

/// The first and the last key of all channels; both are 0 for a clip without a key.
struct TimeRange {
    double first = 0, last = 0;
};
TimeRange time_range(const Clip& clip) noexcept;

/// Wraps `seconds` into the range, as a repeating clip does: its last moment is its first one again. A range of a single
/// moment gives that moment.
double looped(TimeRange range, double seconds) noexcept;

/// Evaluates the channel (glTF 2.0, appendix C): it is clamped at its ends, and rotations are slerped and have unit length.
/// The channel must be one that Scene::add(Clip) accepts.
/// values   has as many elements as the channel is wide; they stay as they are if the channel has no keys
void evaluate(const Channel& channel, double seconds, std::span<double> values) noexcept;

/// A clip at a moment, and its share where several clips animate the same property.
struct ClipAt {
    ClipId clip;
    double seconds = 0;
    double weight = 1;  ///< 0 or more, relative to those of the other clips
};

/// Interpolates along the shorter arc from a to b, both of unit length (Shoemake 1985); t is from 0 to 1.
Vec4d slerp(Vec4d a, Vec4d b, double t) noexcept;

struct Skin {
    std::string name{};
    std::vector<NodeId> joints{};
    std::vector<Mat4d> joint_from_mesh{};  ///< inverse bind matrices; empty: identity
};

}  // namespace occam
