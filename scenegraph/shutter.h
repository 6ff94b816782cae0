// When a frame's shutter is open, and how many segments follow the paths of what moves in it.
//
// Scene::record_shutter() holds poses at evenly spaced keys, and everything moves along chords between them: matrices are
// interpolated as elements, and vertices as positions. So a turn needs several segments. needed_segments() compares the
// chords of fewer segments with a finely recorded shutter.
//
// Time     tau from 0 (open) to 1 (closed) inside a shutter; a Shutter is in frames.
#pragma once

#include "scenegraph/scene.h"

namespace occam {

/// When the shutter opens and closes, in frames from the frame's own time: -0.25 and 0.25 are half a frame around it.
struct Shutter {
    double open = 0, close = 0;

    double length() const noexcept { return close - open; }
    /// Returns false for a shutter that opens and closes at the same moment: the picture is that of the moment.
    bool is_open() const noexcept { return close > open; }
    friend bool operator==(const Shutter&, const Shutter&) = default;
};
/// The farthest moment from a frame's own time, in frames.
inline constexpr double kMaxShutterFrames = 1e6;
/// Throws Error for moments that are not finite, too far away, or in the wrong order.
void check(const Shutter& shutter);

/// How far a point may be from its true path: constant + per_distance * its distance from the eye, world length.
struct PathTolerance {
    Vec3d eye{0};
    double constant = 0, per_distance = 0;

    double at(Vec3d point) const noexcept { return constant + per_distance * glm::distance(point, eye); }
};

/// Returns the least number of segments, a power of two, whose chords pass within the tolerance of every recorded key of
/// the scene; 0 if nothing moves. The scene's own number of segments is the most that it returns. The corners of cages'
/// boxes, and of those that joints move, stand for what is in them.
int needed_segments(const Scene& scene, const PathTolerance& tolerance);

}  // namespace occam
