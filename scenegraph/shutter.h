// How many segments of a shutter follow the paths of what moves while it is open.
//
// Scene::record_shutter() holds poses at evenly spaced keys, and everything moves along chords between them: matrices are
// interpolated as elements, and vertices as positions. So a turn needs several segments. needed_segments() compares the
// chords of fewer segments with a finely recorded shutter.
//
// Time     tau from 0 (the shutter opens) to 1 (it closes).
#pragma once

#include <unordered_set>
#include <vector>

#include "base/error.h"
#include "scenegraph/scene.h"

namespace occam {

/// The error of Scene::record_shutter() if the keys of what moves would take too much memory; those of fewer segments may
/// not.
class ShutterTooLarge : public Error {
public:
    explicit ShutterTooLarge(const Error& error) : Error(error) {}
};

/// How far a point may be from its true path: constant + per_distance * its distance from the eye, world length.
struct PathTolerance {
    Vec3d eye{0};
    double constant = 0, per_distance = 0;
    std::vector<Vec3d> eyes{};  ///< the eye at evenly spaced moments, from when the shutter opens; empty: it stands still

    /// tau   the moment at which the point is there
    double at(Vec3d point, double tau) const noexcept
    {
        const double last = eyes.empty() ? 0 : static_cast<double>(eyes.size() - 1);
        const Vec3d from = eyes.empty() ? eye : eyes[static_cast<std::size_t>(tau * last + 0.5)];
        return constant + per_distance * glm::distance(point, from);
    }
};

/// Returns the least number of segments, a power of two, whose chords pass within the tolerance of every recorded key of
/// the scene, and whose normals are near those of surfaces whose vertices move against each other (kMostTurn); 0 if nothing
/// has keys. The scene's own number of segments is the most that it returns. The corners of cages' boxes, and of
/// those that joints move, stand for what is in them. A node's visibility changes at keys of that many segments as it does
/// at the recorded ones. The scene must be refitted. Of placements in which something moves, the first kMostPlacementsInAll
/// are looked at, and of those beyond them kMostPlacements of each node.
int needed_segments(const Scene& scene, const PathTolerance& tolerance);
inline constexpr int kMostPlacements = 64, kMostPlacementsInAll = 1 << 16;

/// Returns the nodes whose surfaces move, or are hidden for a part of the time, while the shutter is open, in any of their
/// placements, among those that hold one of these kinds of Contents. After Scene::refit() it visits no others.
std::unordered_set<NodeId> moving_nodes(const Scene& scene, Contents::Kinds kinds);

}  // namespace occam
