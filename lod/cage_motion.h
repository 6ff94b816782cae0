// Measures how a placed cage moves in the shutter of a frame, and makes the keys at which it is diced.
//
// The scene records placements, joints, morph weights and vertices at the keys of its shutter. A placed cage takes every
// n-th of these keys, such that none that it leaves out lies far from the straight line between its neighbours.
//
// Space    world, and the dicing frame of PosedCage, which is one for all keys.
// Memory   the keys lie in a worker's arena.
// Threads  const after construction.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "lod/footprint.h"
#include "lod/posed_cage.h"
#include "lod/topology_cache.h"

namespace occam::lod {

/// Holds what posing a cage needs.
struct PosingTools {
    const CageTables& tables;
    const TextureStore* textures;  ///< null: nothing is displaced
    Arena& arena;
    DeformCounters& counters;
};

class CageMotion {
public:
    /// Borrows its arguments.
    /// skin              the node's, or null
    /// world_from_node   at each key of the shutter, or once if the placement stands still
    /// segments          of the scene's shutter; 0: it has none
    CageMotion(const CageSlot& slot, const Node& node, const SkinSlot* skin, std::span<const Mat4d> world_from_node,
               int segments);

    /// Returns whether any vertex moves.
    bool moves() const noexcept { return changes_ > 0; }
    /// Returns a box, in world axes, that the cage never leaves.
    Box3d world_box() const noexcept;
    /// Returns the least power of two of segments with which no control point is farther than `tolerance` from where the
    /// scene's keys have it. Where vertices are written or morph weights change, no normal of a face is off by more than
    /// kMostTurn, either; those of skins are not looked at.
    int segments(double tolerance) const
    {
        return segments([tolerance](int) { return tolerance; });
    }
    /// Does the same with a tolerance for each key.
    int segments(const std::function<double(int key)>& tolerance) const;
    /// Returns a box, in world axes, that holds the cage at a key of the scene's shutter.
    Box3d world_box_at(int key) const;
    /// Returns a lower bound, seen from the eye, on the distance across the line of sight that each point of the cage moves
    /// per shutter, at each moment of the shutter. It is 0 if some point may stand still, and for cages that deform or are
    /// displaced: nothing says then how much longer edges would cut off.
    double least_distance_across(Vec3d eye) const;
    /// Returns an estimate of the least radius with which the surface of a rigid cage bends, in world length.
    double least_radius(const CageCurvature& curvature) const;
    /// Makes the cage at the keys of a motion of so many segments. All keys are copies of `still`, in the same dicing frame,
    /// unless there is a still pose that goes far.
    PosedCage& make_keys(const PosedCage& still, int segments, const PosingTools& tools) const;
    /// Returns the segments of the scene's shutter in groups in which a cage that moves in so many segments has about the
    /// same size, as masks; fewer than two if it has it in the whole shutter. See growth.h.
    std::vector<std::uint32_t> segments_by_size(int segments) const;
    /// Does what make_keys() does, for some segments of the scene's shutter alone and in a dicing frame for these.
    /// shown   one of segments_by_size(segments)
    PosedCage& make_keys_in(const PosedCage& still, std::uint32_t shown, int segments, const PosingTools& tools) const;

private:
    /// Returns whether every moment's cage is an affine image of every other's. Skins and morph targets move vertices
    /// against each other.
    bool moves_by_nodes_alone() const noexcept { return moves_maps_ && !is_skinned_ && changes_ == 1; }
    /// Returns the pose of which all others are affine images, made of the largest one of the keys; null if rays cannot be
    /// taken to it at all times. Call it if moves_by_nodes_alone().
    const PosedCage* make_still_pose(std::span<const PosedCage> keys, std::uint32_t shown, const PosingTools& tools) const;
    /// Poses the cage at the keys of a motion of so many segments. Keys that are no end of a segment in `shown` are the same
    /// as one that is.
    std::span<PosedCage> pose_keys(const PosedCage& still, int segments, const Box3d& frame, std::uint32_t shown,
                                   const PosingTools& tools) const;
    /// Sets what the poses at all keys share, and returns the first.
    /// radii   of the cage at each of the keys
    PosedCage& finish_keys(std::span<PosedCage> keys, std::span<const double> radii, std::uint32_t shown,
                           const PosingTools& tools) const;
    /// Poses each key anew in a dicing frame of its own, where coordinates are small. Call it only if there is a still pose,
    /// since igrids of keys need one frame.
    void move_keys_apart(std::span<PosedCage> keys, std::uint32_t shown, const PosingTools& tools) const;
    /// Returns the last key of the scene's shutter, up to this one, that is an end of a segment in `shown`; else the first.
    int shown_key(int key, std::uint32_t shown) const noexcept;
    const Mat4d& world(int key) const noexcept { return world_[world_.size() > 1 ? std::size_t(key) : 0]; }
    CagePose pose(int key) const noexcept { return {slot_, node_, skin_, key}; }
    /// Returns whether the cage keeps its shape but for what its nodes do to it.
    bool is_rigid() const noexcept { return moves_by_nodes_alone() && !slot_.is_deformed() && !slot_.cage.is_displaced(); }
    double deviation(int key, int before, int after) const;
    double deviation_of_maps(int key, int before, int after) const;
    double deviation_of_weights(int key, int before, int after) const;
    double deviation_of_positions(int key, int before, int after) const;
    /// What the normals' turning adds, where vertices move.
    double deviation_of_displacement(int key, int before, int after) const;
    /// Returns whether the normals between two keys are about those that a key between them has. Of many faces some are
    /// seen.
    bool keeps_normals(int key, int before, int after) const;
    Vec3d normal_at(int key, FaceVertices face) const;

    const CageSlot& slot_;
    const Node& node_;
    const SkinSlot* skin_;
    std::span<const Mat4d> world_;
    int segments_;
    bool is_skinned_;
    bool moves_maps_ = false, moves_weights_ = false, moves_positions_ = false;
    int changes_ = 0;                  ///< how many of these are true
    std::vector<FaceVertices> faces_;  ///< if the normals' turning counts: some of them, or all of a displaced cage
};

/// Returns how far control points in the box may be from where the scene's keys have them, unseen:
/// LevelSettings::motion_edges of the target edge length where the box is nearest to the camera, and no less than rounding.
double motion_tolerance(const LevelSettings& settings, const Box3d& world) noexcept;
/// Returns the largest value that motion_tolerance() may have for a box within this one.
double largest_motion_tolerance(const LevelSettings& settings, const Box3d& world) noexcept;

/// Returns the level that is fine enough for a cage that moves so fast: its edges are as long as the least distance that a
/// point of it moves across the picture in one of LevelSettings::strata, but no more than four pixels where the cage is
/// nearest to the camera, and no longer than its bend allows. Returns kFinestLevel if motion makes nothing coarser.
int level_of_motion(const LevelSettings& settings, const CageMotion& motion, const CageCurvature& curvature);

}  // namespace occam::lod
