// Clips, skins and how a node is posed by them.
//
// A clip says what its nodes' places and morph weights are at a moment; Scene::pose() writes that into the nodes. What
// follows from a node's place for the vertices that hang on it (skins, morph targets) is described only: lod/deformed_cage.h
// has the rest.
//
// Space    each value in its node's parent's axes, as Trs.   Time  seconds on the clip's own axis.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scenegraph/ids.h"

namespace occam {

/// A node's place in its parent by parts, which clips move; quaternion as (x, y, z, w), unit.
struct Trs {
    Vec3d translation{0};
    Vec4d rotation{0, 0, 0, 1};
    Vec3d scale{1};
    Mat4d matrix() const noexcept;
};

/// One animated property of one node (glTF 2.0, animation.channel and its sampler).
struct Channel {
    enum class Path : unsigned char { Translation, Rotation, Scale, Weights };
    enum class Interpolation : unsigned char { Step, Linear, CubicSpline };
    NodeId target;
    Path path = Path::Translation;
    Interpolation interpolation = Interpolation::Linear;
    std::vector<float> times;   ///< seconds, strictly rising
    std::vector<float> values;  ///< width floats a key; CubicSpline: in-tangent, value, out-tangent a key
    int width = 3;
};
struct Clip {
    std::string name;
    std::vector<Channel> channels;
};

/// First and last key of all channels; both 0 for a clip without a key.
struct TimeRange {
    double first = 0, last = 0;
};
TimeRange time_range(const Clip& clip) noexcept;

/// `seconds` brought into the range as a clip that repeats has it: last is first again. A range of one moment is that
/// moment.
double looped(TimeRange range, double seconds) noexcept;

/// The channel's value (glTF 2.0, appendix C): clamped at its ends, rotations by slerp and of unit length.
/// values   as many as the channel's width
void evaluate(const Channel& channel, double seconds, std::span<double> values) noexcept;

/// A clip at a moment, and its share where several move the same property.
struct ClipAt {
    ClipId clip;
    double seconds = 0;
    double weight = 1;  ///< 0 or more, relative to those of the other clips
};

/// The shorter way round from a to b, both unit (Shoemake 1985); t from 0 to 1.
Vec4d slerp(Vec4d a, Vec4d b, double t) noexcept;

struct Skin {
    std::string name;
    std::vector<NodeId> joints;
    std::vector<Mat4d> joint_from_mesh;  ///< inverse bind matrices; empty: identity
};

}  // namespace occam
