// Holds one ray while it walks through a tree by itself (accel/walk.h), and sends it through igrids with micropolygons in
// the lanes. It does what PacketRays does, with the same bits.
#pragma once

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
        : query(hits), ray_(ray), frame_(frame), levels_(levels)
    {
        const PlacedOrigin start = place(ray, frame.anchor, frame.radius);
        const float way[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
        float shear[3];
        set_shear(axes, way, shear);
        set_inverse(axes, way, in_tree.inverse);
        lanes_.kx = axes.kx;
        lanes_.ky = axes.ky;
        lanes_.kz = axes.kz;
        lanes_.sx = shear[0];
        lanes_.sy = shear[1];
        lanes_.sz = shear[2];
        in_tree.shift = start.shift;
        for (int a = 0; a < 3; ++a) {
            in_tree.origin[a] = start.origin[a];
            in_tree.negative[a] = axes.negative[a];
            in_tree.direction[a] = way[a];
            lanes_.inverse[a] = in_tree.inverse[a];
            direction_[a] = way[a];
        }
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
        levels_.set({reach.target_edge.a, reach.target_edge.b, reach.start}, t_in, t_out, reach.coordinate, frame_.levels);
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
        const PlacedOrigin at = place(ray_, cage.anchor, cage.radius);
        for (int a = 0; a < 3; ++a) lanes_.origin[a] = at.origin[a];
        lanes_.shift = at.shift;
    }

    void set_blend(const lod::Blend<float>& blend) noexcept
    {
        lanes_.blend.set({blend.start, blend.scale}, direction_, lanes_.origin, lanes_.shift);
    }

    /// Intersects an igrid of the cage at which the ray is placed.
    OCCAM_ALWAYS_INLINE void meet(IGrid& grid, bool, bool, float from, float to) noexcept
    {
        if (grid.segments > 0) meet_moving(grid, {rays(), {lanes_, in_tree.negative, {from, to}}}, query);
        else meet_single(grid, {lanes_, in_tree.negative, {from, to}}, query.only, query);
        if constexpr (kIsObserved<Found>)
            if (query.narration) {
                GridHit like{0, &grid, 0, {}, lod::key_time(ray_.time, std::max(grid.segments, 1))};
                if (grid.blends()) like.blend = levels_.blend(grid.pairs.finest);
                query.narration->igrid({like, lanes_, direction_, from, to}, query.offered, t_far());
            }
    }

private:
    const Ray& ray_;
    const FrameState& frame_;
    lod::RayLevels<float>& levels_;
    RayLanes lanes_;
    vfloat direction_[3];
};

}  // namespace occam::accel
