// Finds points inside a closed cage, from which rays start.
//
// A point needs room on all sides, since the coarser meshes that rays see from there may pass by it. A few points anywhere
// in a cage of many parts, or of thin ones, see few of its faces. So points are looked for behind faces, too.
//
// Space    world axes, from the anchor of the cage at its moment (Subject::anchor_at).
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "verify/mesh_pieces.h"
#include "verify/target.h"

namespace occam {

/// Finest meshes that have more corners than this, at all moments together that are looked at, are refined no further.
inline constexpr std::size_t kMostCorners = 2'000'000;

inline constexpr std::uint32_t kNoFace = std::numeric_limits<std::uint32_t>::max();

struct Start {
    Vec3d at;
    double reach;                  ///< edges longer than this may put the point outside
    std::uint32_t face = kNoFace;  ///< the face behind which the point was looked for, if any
};

/// A moment of the shutter, the meshes of the cage then, from the finest level on, and points that are inside of them.
struct Instant {
    float time = 0;
    std::vector<Subject::Pair> pairs;
    std::vector<Start> starts;
    bool has_inside = false;  ///< whether points inside were found, at this level or at another
    bool is_seen = false;     ///< whether rays were sent
};

class StartSearch {
public:
    /// instant    is borrowed, and gets the starts
    /// instants   the number of moments, which share the time that the search may take
    StartSearch(Instant& instant, const Subject& subject, std::size_t instants, Random& random);

    /// Looks for points anywhere in the cage.
    /// is_last   whether no finer level follows: then more points are tried until one is inside
    void anywhere(bool is_last);

    /// Looks for a point behind each of some of these faces, chosen at random. Returns how many it found. They may have
    /// less room than points anywhere. Points in displaced cages may not, since they could lie outside of the cage at finer
    /// levels.
    std::size_t behind(std::span<const std::uint32_t> faces);

private:
    /// Adds the point to the starts if it is inside, and returns whether it is.
    /// least   no vertex may be nearer than that
    bool try_at(Vec3d p, double least, bool needs_room, std::uint32_t face = kNoFace);
    /// Returns whether a point is inside of the fine mesh, and of all coarser ones that rays from there may see.
    /// reach        edges longer than twice that are not seen from there
    /// needs_room   whether there must be a little room on all sides; to look for it takes seven times as long
    bool is_inside_at(Vec3d p, double reach, bool needs_room) const;
    bool try_behind(std::uint32_t face);

    Instant& instant_;
    Random& random_;
    const MeshPieces pieces_;
    const std::size_t instants_, triangles_;
    const bool is_displaced_;
    const int turn_;     ///< -1 if the meshes are mirrored, and so wind the other way around, else 1
    const double edge_;  ///< the longest of the finest mesh
    Box3d box_;
};

}  // namespace occam
