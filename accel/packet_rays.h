// Holds the rays of a packet while they walk through a tree (accel/walk.h), and sends them through igrids.
//
// The rays share their axes and octant. They meet an igrid as many at a time as there are lanes; where few of these are
// left, each is traced alone, with micropolygons in the lanes.
#pragma once

#include <bit>
#include <cstddef>

#include "accel/affine_ray.h"
#include "accel/moving_igrid.h"
#include "accel/ray_reach.h"

namespace occam::accel {

template <class FoundOfRays, int kParts>
class PacketRays {
public:
    using Found = FoundOfRays;
    using Lanes = vfloats<kParts>;
    using Mask = vmasks<kParts>;

    /// levels   receives the packet's table of transitions
    PacketRays(std::span<const Ray> rays, const RayAxes& axes, const FrameState& frame, lod::RayLevels<Lanes>& levels,
               PacketQuery<Found, kParts>& query) noexcept
        : rays_(rays), frame_(frame), levels_(levels), query_(query)
    {
        static_assert(offsetof(Ray, t_near) == offsetof(Ray, direction) + 3 * sizeof(float));
        Lanes start[4], shear[3];
        gather_four(rays.data(), rays.size(), offsetof(Ray, direction), way_);
        place_all(
            rays, way_, [&](std::size_t) -> const FrameState& { return frame; }, start);
        set_shear(axes, way_, shear);
        set_inverse(axes, way_, in_tree.inverse);
        in_tree.shift = start[3];
        for (int a = 0; a < 3; ++a) {
            in_tree.origin[a] = start[a];
            in_tree.negative[a] = axes.negative[a];
            in_tree.direction[a] = way_[a];
        }
        in_tree.set_off_slab();
        for (int p = 0; p < kParts; ++p) set_constants(parts_[p].lanes, p, axes, shear, in_tree.inverse);
    }

    TreeRay<Lanes> in_tree;  ///< in the frame of the tree

    std::span<const Ray> rays() const noexcept { return rays_; }
    const Lanes& t_near() const noexcept { return way_[3]; }
    Lanes t_far() const noexcept { return query_.limit(); }

    /// Makes the table of transitions of the rays `enters`, which are in the scene from t_in to t_out. Returns null if they
    /// see too many pairs to travel together.
    lod::RayLevels<Lanes>* find_levels(const Mask& enters, const Lanes& t_in, const Lanes& t_out) noexcept
    {
        // A ray that misses the scene gets the table of one that does not, so that it asks for no additional pairs.
        const auto one = static_cast<std::size_t>(std::countr_zero(bits(enters)));
        RayReach reach[kParts * kLanes]{};
        alignas(32) float focus[kParts * kLanes]{};
        for (std::size_t i = 0; i < rays_.size(); ++i) {
            reach[i] = reach_of(rays_[bits(enters) >> i & 1 ? i : one], frame_);
            focus[i] = reach[i].focus;
        }
        Lanes of[4];
        gather_four(reach, rays_.size(), 0, of);
        const auto of_one = [&](const Lanes& x) {
            float lanes[kParts * kLanes];
            x.store(lanes);
            return Lanes(lanes[one]);
        };
        const bool fits = levels_.set({of[0], of[1], of[3], Lanes::load(focus)}, select(enters, t_in, of_one(t_in)),
                                      select(enters, t_out, of_one(t_out)), of[2], frame_.levels);
        return fits ? &levels_ : nullptr;
    }

    /// Returns those of the rays `entering` that may see the igrid and did not meet it before in this visit, as bits, and
    /// notes that they have met it. The rays that may not see it are removed from `entering`.
    OCCAM_ALWAYS_INLINE unsigned note_visit(GridVisit& visited, std::uint64_t visit, const IGrid& grid,
                                            Mask& entering) const noexcept
    {
        // An igrid that a ray enters in several cells is tested once.
        if (visited.packet != visit) visited = {visit, 0};
        if (grid.is_hidden) entering = entering & lanes_that_may_see<kParts>(rays_, *grid.cage, frame_.segments);
        const unsigned fresh = bits(entering) & ~visited.lanes;
        visited.lanes |= fresh;
        return fresh;
    }

    /// Takes the rays to the frame of a cage.
    void place_at(const lod::PosedCage& cage) noexcept
    {
        still_pose_ = cage.affine ? &cage : nullptr;
        if (still_pose_) {
            // Rays are taken there when they meet an igrid.
            placed_ = 0;
            here_ = still_parts_;
            negative_ = &still_axes_.negative;
            return;
        }
        here_ = parts_;
        negative_ = &in_tree.negative;
        Lanes placed[4];
        place_all(
            rays_, way_, [&](std::size_t) -> const lod::PosedCage& { return cage; }, placed);
        for (int p = 0; p < kParts; ++p) {
            for (int a = 0; a < 3; ++a) parts_[p].lanes.origin[a] = placed[a].part[p];
            parts_[p].lanes.shift = placed[3].part[p];
            parts_[p].is_as_one_placed = false;
        }
    }

    void set_blend(const lod::Blend<Lanes>& blend) noexcept
    {
        if (still_pose_) {
            blend_ = blend;
            is_blend_set_ = false;
        } else {
            set_blend_of_parts(blend, way_);
        }
    }

    /// Intersects an igrid of the cage at which the rays are placed with the rays `fresh`.
    OCCAM_ALWAYS_INLINE void meet(IGrid& grid, unsigned fresh, const Mask& entering, const Lanes& from,
                                  const Lanes& to) noexcept
    {
        // A packet is tested with all rays that enter, also with those that have met the igrid before.
        if (still_pose_ && !take_to_still_pose(grid, bits(entering))) return meet_one_by_one(grid, fresh, from, to);
        for (int p = 0; p < kParts; ++p) {
            const unsigned of_part = fresh >> (p * kLanes) & ((1u << kLanes) - 1);
            if (of_part != 0) meet_part(grid, p, of_part, entering.part[p], {from.part[p], to.part[p]});
        }
    }

private:
    /// Holds as many rays as there are lanes, in the frame of the cage whose igrid is being tested.
    struct Part {
        RayLanes lanes;
        RaysAsOne<vfloat> as_one;
        bool is_as_one_placed = false;
    };

    OCCAM_ALWAYS_INLINE void meet_part(IGrid& grid, int p, unsigned of_part, vmask entering, const RaySpan& span) noexcept
    {
        Part& part = here_[p];
        PartOf<Found> some{query_, p * kLanes};
        if (grid.segments > 0) {
            const std::size_t first = static_cast<std::size_t>(p) * kLanes;
            meet_moving(grid, {rays_.subspan(first), {part.lanes, *negative_, span}}, of_part, some);
            return;
        }
        if (std::popcount(of_part) >= kWorthAPacket) {
            meet_packet(grid, {part.lanes, *negative_, span}, entering, some, [&]() -> const RaysAsOne<vfloat>& {
                if (!part.is_as_one_placed)
                    part.as_one = {part.lanes.origin, part.lanes.inverse, *negative_, part.lanes.shift, -FLT_MAX};
                part.is_as_one_placed = true;
                return part.as_one;
            });
            return;
        }
        for (unsigned left = of_part; left != 0; left &= left - 1) {
            const int lane = std::countr_zero(left);
            LaneOf<Found> one{some, lane};
            RayLanes ray = spread(part.lanes, lane);
            if (grid.blends()) ray.blend = spread(part.lanes.blend, lane);
            const RaySpan own{spread(span.t_near, lane), spread(span.t_end, lane)};
            meet_single(grid, {ray, *negative_, own}, lane, one);
        }
    }

    /// Sets the blend where the rays are placed. `gradient` is that of t over points there.
    void set_blend_of_parts(const lod::Blend<Lanes>& blend, const Lanes* gradient) noexcept
    {
        for (int p = 0; p < kParts; ++p) {
            RayLanes& lanes = here_[p].lanes;
            lanes.blend.set({blend.start.part[p], blend.scale.part[p]},
                            {gradient[0].part[p], gradient[1].part[p], gradient[2].part[p]}, lanes.origin, lanes.shift);
        }
    }

    /// Takes the rays `entering`, given as bits, to the still pose, if they were not. Returns false if they do not have the
    /// same axes there.
    OCCAM_NEVER_INLINE bool take_to_still_pose(const IGrid& grid, unsigned entering) noexcept
    {
        if ((entering & ~placed_) != 0) {
            for (unsigned left = entering & ~placed_; left != 0; left &= left - 1) {
                const int lane = std::countr_zero(left);
                const AffineRay ray(rays_[static_cast<std::size_t>(lane)], *still_pose_);
                if (placed_ == 0) {
                    // The first ray stands for all that are not known yet.
                    still_axes_ = ray.axes;
                    are_alike_ = 0;
                    still_.fill(ray);
                }
                placed_ |= 1u << lane;
                if (!(ray.axes == still_axes_)) continue;
                are_alike_ |= 1u << lane;
                still_.set(lane, ray);
            }
            set_still_parts();
            is_blend_set_ = false;
        }
        if ((entering & ~are_alike_) != 0) return false;
        if (grid.blends() && !is_blend_set_) {
            const Lanes gradient[3] = {still_.load(7), still_.load(8), still_.load(9)};
            set_blend_of_parts(blend_, gradient);
            is_blend_set_ = true;
        }
        return true;
    }
    /// Sets what igrids are tested by from the rays in the still pose.
    void set_still_parts() noexcept
    {
        const Lanes way[3] = {still_.load(4), still_.load(5), still_.load(6)};
        Lanes shear[3], inverse[3];
        set_shear(still_axes_, way, shear);
        set_inverse(still_axes_, way, inverse);
        for (int p = 0; p < kParts; ++p) {
            RayLanes& lanes = still_parts_[p].lanes;
            set_constants(lanes, p, still_axes_, shear, inverse);
            for (int a = 0; a < 3; ++a) lanes.origin[a] = still_.load(a).part[p];
            lanes.shift = still_.load(3).part[p];
            still_parts_[p].is_as_one_placed = false;
        }
    }

    /// Sets what follows from the directions of the rays of a part.
    static void set_constants(RayLanes& lanes, int p, const RayAxes& axes, const Lanes (&shear)[3],
                              const Lanes (&inverse)[3]) noexcept
    {
        lanes.kx = axes.kx;
        lanes.ky = axes.ky;
        lanes.kz = axes.kz;
        lanes.sx = shear[0].part[p];
        lanes.sy = shear[1].part[p];
        lanes.sz = shear[2].part[p];
        for (int a = 0; a < 3; ++a) lanes.inverse[a] = inverse[a].part[p];
    }

    /// Intersects an igrid of a still pose, where each ray has its own axes.
    OCCAM_NEVER_INLINE void meet_one_by_one(IGrid& grid, unsigned fresh, const Lanes& from, const Lanes& to) noexcept
    {
        alignas(32) float t_near[kParts * kLanes], t_end[kParts * kLanes], start[kParts * kLanes]{},
            scale[kParts * kLanes]{};
        from.store(t_near);
        to.store(t_end);
        if (grid.blends()) {
            blend_.start.store(start);
            blend_.scale.store(scale);
        }
        for (; fresh != 0; fresh &= fresh - 1) {
            const int i = std::countr_zero(fresh), lane = i % kLanes;
            const AffineRay ray(rays_[static_cast<std::size_t>(i)], *still_pose_);
            RayLanes lanes = ray.lanes();
            const vfloat gradient[3] = {ray.gradient[0], ray.gradient[1], ray.gradient[2]};
            if (grid.blends()) lanes.blend.set({start[i], scale[i]}, gradient, lanes.origin, lanes.shift);
            LaneOf<Found> one{PartOf<Found>{query_, i - lane}, lane};
            meet_single(grid, {lanes, ray.axes.negative, {t_near[i], t_end[i]}}, lane, one);
        }
    }

    static constexpr int kRays = kParts * kLanes;

    /// Holds rays in a still pose by rows: origin, shift, direction and gradient of t over points.
    struct StillRays {
        alignas(32) float rows[10][kRays];

        void fill(const AffineRay& ray) noexcept
        {
            for (int a = 0; a < 3; ++a) {
                Lanes(ray.origin[a]).store(rows[a]);
                Lanes(ray.direction[a]).store(rows[4 + a]);
                Lanes(ray.gradient[a]).store(rows[7 + a]);
            }
            Lanes(ray.shift).store(rows[3]);
        }
        void set(int i, const AffineRay& ray) noexcept
        {
            for (int a = 0; a < 3; ++a) {
                rows[a][i] = ray.origin[a];
                rows[4 + a][i] = ray.direction[a];
                rows[7 + a][i] = ray.gradient[a];
            }
            rows[3][i] = ray.shift;
        }
        Lanes load(int row) const noexcept { return Lanes::load(rows[row]); }
    };

    std::span<const Ray> rays_;
    const FrameState& frame_;
    lod::RayLevels<Lanes>& levels_;
    PacketQuery<Found, kParts>& query_;
    Lanes way_[4];  ///< direction and t_near
    Part parts_[kParts];
    // Where the rays are placed: in the tree's axes, or in a still pose.
    Part* here_ = parts_;
    const bool (*negative_)[3] = &in_tree.negative;
    const lod::PosedCage* still_pose_ = nullptr;  ///< null: the rays are in the tree's axes
    unsigned placed_ = 0, are_alike_ = 0;         ///< rays that were taken there, and those whose axes are still_axes_
    RayAxes still_axes_;
    StillRays still_;
    Part still_parts_[kParts];
    lod::Blend<Lanes> blend_;  ///< the rays' blend there
    bool is_blend_set_ = false;
};

}  // namespace occam::accel
