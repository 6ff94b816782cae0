// Holds one ray while it walks through a tree by itself (accel/walk.h), and sends it through igrids with micropolygons in
// the lanes. It does what PacketRays does, with the same bits.
#pragma once

#include "accel/affine_ray.h"
#include "accel/moving_igrid.h"
#include "accel/narration.h"
#include "accel/ray_reach.h"

namespace occam::accel {

template <class FoundOfRay>
class LoneRay {
public:
    using Found = FoundOfRay;
    using Lanes = float;
    using Mask = bool;

    /// levels   receives the ray's table of transitions
    LoneRay(const Ray& ray, const RayAxes& axes, const FrameState& frame, lod::RayLevels<float>& levels,
            SingleQuery<Found>& hits) noexcept
        : query(hits), ray_(ray), axes_(axes), frame_(frame), levels_(levels)
    {
        const PlacedOrigin start = place(ray, frame.anchor, frame.radius);
        set_inverse(axes, &ray.direction.x, in_tree.inverse);
        in_tree.shift = start.shift;
        for (int a = 0; a < 3; ++a) {
            in_tree.origin[a] = start.origin[a];
            in_tree.negative[a] = axes.negative[a];
            in_tree.direction[a] = ray.direction[a];
        }
        in_tree.set_off_slab();
        keep_directions();
    }

    TreeRay<float> in_tree;  ///< in the frame of the tree
    SingleQuery<Found>& query;

    std::span<const Ray> rays() const noexcept { return {&ray_, 1}; }
    float t_near() const noexcept { return ray_.t_near; }
    float t_far() const noexcept { return query.t[query.only]; }

    /// Makes the ray's table of transitions. One ray has at most RayLevels::kMostOfRay pairs, for which the table always has
    /// room.
    lod::RayLevels<float>* find_levels(bool, float t_in, float t_out) noexcept
    {
        const RayReach reach = reach_of(ray_, frame_);
        const lod::RayWidth<float> width{reach.target_edge.a, reach.target_edge.b, reach.start, reach.focus};
        levels_.set(width, t_in, t_out, reach.coordinate, frame_.levels);
        return &levels_;
    }

    /// Returns whether the ray may see the igrid and did not meet it before in this visit, and notes that it has met it.
    OCCAM_ALWAYS_INLINE bool note_visit(GridVisit& visited, std::uint64_t visit, const IGrid& grid, bool&) noexcept
    {
        if (visited.packet == visit || (grid.is_hidden && !may_see(ray_, *grid.cage, frame_.segments))) {
            if constexpr (kIsObserved<Found>) query.skips_igrid(grid, visited.packet == visit);
            return false;
        }
        visited.packet = visit;
        if constexpr (kIsObserved<Found>) query.enters_igrid();
        return true;
    }

    /// Takes the ray to the frame of a cage.
    void place_at(const lod::PosedCage& cage) noexcept
    {
        if (cage.affine) return place_at_still_pose(cage);
        if (is_turned_) keep_directions();
        const PlacedOrigin at = place(ray_, cage.anchor, cage.radius);
        for (int a = 0; a < 3; ++a) lanes_.origin[a] = at.origin[a];
        lanes_.shift = at.shift;
    }

    void set_blend(const lod::Blend<float>& blend) noexcept
    {
        lanes_.blend.set({blend.start, blend.scale}, gradient_, lanes_.origin, lanes_.shift);
    }

    /// Intersects an igrid of the cage at which the ray is placed.
    OCCAM_ALWAYS_INLINE void meet(IGrid& grid, bool, bool, float from, float to) noexcept
    {
        if (grid.segments > 0) meet_moving(grid, {rays(), {lanes_, negative_, {from, to}}}, query);
        else meet_single(grid, {lanes_, negative_, {from, to}}, query.only, query);
        if constexpr (kIsObserved<Found>)
            if (query.narration) {
                GridHit like{0, &grid, 0, {}, lod::key_time(ray_.time, std::max(grid.segments, 1)), 0};
                if (grid.blends()) like.blend = levels_.blend(grid.pairs.finest);
                query.narration->igrid({like, lanes_, gradient_, from, to}, query.offered, t_far());
            }
    }

private:
    /// Sets what follows from the ray's own direction, which all cages see but those that are taken to a still pose.
    OCCAM_ALWAYS_INLINE void keep_directions() noexcept
    {
        float shear[3];
        set_shear(axes_, &ray_.direction.x, shear);
        lanes_.kx = axes_.kx;
        lanes_.ky = axes_.ky;
        lanes_.kz = axes_.kz;
        lanes_.sx = shear[0];
        lanes_.sy = shear[1];
        lanes_.sz = shear[2];
        for (int a = 0; a < 3; ++a) {
            lanes_.inverse[a] = in_tree.inverse[a];
            negative_[a] = in_tree.negative[a];
            gradient_[a] = in_tree.direction[a];
        }
        is_turned_ = false;
    }
    OCCAM_NEVER_INLINE void place_at_still_pose(const lod::PosedCage& cage) noexcept
    {
        const AffineRay at(ray_, cage);
        lanes_ = at.lanes();
        for (int a = 0; a < 3; ++a) {
            negative_[a] = at.axes.negative[a];
            gradient_[a] = at.gradient[a];
        }
        is_turned_ = true;
    }

    const Ray& ray_;
    const RayAxes& axes_;
    const FrameState& frame_;
    lod::RayLevels<float>& levels_;
    RayLanes lanes_;
    vfloat gradient_[3];  ///< of t over points of the cage's frame: the direction, unless the ray is in a still pose
    bool negative_[3];    ///< in the cage's frame
    bool is_turned_;      ///< the ray is in a still pose
};

}  // namespace occam::accel
