// The width of a ray's beam, and the level of detail that it asks for.
//
// Djeu et al. 2011, sec. 5.2.6. At level l, which is any integer, micropolygon edges are at most d_l = 2^l world units long.
// Levels are the same everywhere: they do not depend on the scene's size or the camera.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/box.h"
#include "base/power_of_two.h"
#include "lod/longest_edges.h"

namespace occam::lod {

/// The full width of a beam at distance t: A + B t, world length.
struct Footprint {
    float a = 0, b = 0;
    float at(float t) const noexcept { return std::max(0.0f, a + b * t); }
};

/// Returns d_l.
inline float edge_length(int level) noexcept { return power_of_two(level); }

/// Says which target edge length decides the level.
enum class LevelMode {
    PerRay,      ///< each ray's own footprint, along the ray
    Frozen,      ///< as PerRay for rays from the camera; others keep their width at the origin
    PerInstance  ///< a placement has one level for all rays, by the camera's smallest footprint on it
};

/// Says how a frame chooses levels.
struct LevelSettings {
    static constexpr float kOverlapEdges = 0.1f;

    Vec3d eye{0};            ///< of mid-shutter if the camera moves
    Footprint pixel;         ///< footprint of one pixel of the camera
    float shading_rate = 1;  ///< target edge length, in widths of the footprint
    int plane_count = 0;     ///< planes of the view; what lies outside of one does not choose (PerInstance)
    Vec4d planes[4]{};       ///< inside where dot(xyz, p - eye) >= 0; w is not used
    LevelMode mode = LevelMode::PerRay;
    /// Segments of a ray overlap by the larger of these: in edges of the finer pair, and in ulps of the largest coordinate
    /// where they meet (watertightness rule 13). Tests make them small, since a wide overlap hides faults.
    float overlap_edges = kOverlapEdges, overlap_ulps = 16;
    /// The ulps are those of no smaller coordinate than this one, in world length. A tenth of an edge is always more than 25
    /// ulps of a cage's radius (PosedCage::finest_level), so that only those who make overlap_edges smaller need it.
    float least_coordinate = 0;
    /// The farthest that a control point may be, between the keys of a cage's motion, from where the scene's keys have it:
    /// in target edge lengths where the cage is nearest to the camera.
    float motion_edges = 0.25f;
    /// The farthest that the eye is from `eye` while the shutter is open. The keys of cages that move are chosen for an eye
    /// that is nearer by as much.
    double eye_moves = 0;
    /// The eye at evenly spaced moments of the shutter, and on straight lines between them; empty: it stands still. The one
    /// level of a placement is chosen by it (PerInstance).
    std::vector<Vec3d> eyes{};
    /// The number of equal parts of the shutter of which each pixel samples every one; 0: it is not known. A cage all of
    /// whose points move across the picture has no edges that are shorter than the least distance that a point moves in one
    /// part (lod/cage_motion.h).
    int strata = 0;

    /// The origin of the floats in which the tree keeps boxes of igrids; no value: there is no tree. No placed cage has
    /// edges that are shorter than the steps of these floats are where it is (lod/level_choice.h).
    std::optional<Vec3d> origin{};
    /// The largest distance, in world length, of points of displaced cages from the surface whose edges levels bound. An
    /// edge of M_l may be longer than d_l by twice this, and a vertex may move by the same amount more between levels, so
    /// margins grow by both.
    float displaced = 0;
    /// The longest edges of the scene's cages at each level, without displacement.
    LongestEdges edges{};

    /// Edges of the finer level of a pair are at most 1.41 times the target edge length, and at least half of that wherever
    /// the cage's own faces are not smaller. So the blended edges have the target length on the average over all distances.
    /// If they were never to be longer, twice as many micropolygons would be needed (tests/unit/accel_levels_test.cpp).
    static constexpr float kLongestEdge = 1.41421356f;
    /// Returns the length by which a level is chosen: d_l <= length < d_(l+1).
    Footprint target_edge(Footprint width) const noexcept
    {
        const float scale = shading_rate * kLongestEdge;
        return {width.a * scale, width.b * scale};
    }
};

}  // namespace occam::lod
