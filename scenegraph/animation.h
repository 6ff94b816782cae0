// Clips, skins and how a node is posed by them: described here, executed when a frame asks for it.
#pragma once

#include <string>
#include <vector>

#include "scenegraph/base/vec.h"
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

struct Skin {
    std::string name;
    std::vector<NodeId> joints;
    std::vector<Mat4d> joint_from_mesh;  ///< inverse bind matrices; empty: identity
};

}  // namespace occam
