// Holds the rays whose hits are resolved, in lanes, each in the frame of the cage that it has hit.
//
// Space    world axes, from the anchor of each lane's cage. What rays have hit in a still pose is moved to where it is at
//          their times (lod/affine_motion.h).
#pragma once

#include <bit>

#include "accel/affine_ray.h"
#include "accel/corners.h"
#include "accel/packet.h"

namespace occam::accel {

struct HitRays {
    struct Frame {
        Vec3d anchor;
        float radius;
    };
    vfloat way[4];            ///< direction and t_near
    vfloat origin[4];         ///< origin and shift, as place_all() gives them
    unsigned in_still;        ///< bit mask of lanes whose cage is hit in a still pose
    AffineRay still[kLanes];  ///< valid in these lanes

    /// any           takes the place of the igrids of rays that hit nothing
    /// still_lanes   become in_still
    HitRays(std::span<const Ray> rays, std::span<const GridHit> met, const IGrid& any, unsigned still_lanes) noexcept
        : in_still(still_lanes), met_(met)
    {
        gather_four(rays.data(), rays.size(), offsetof(Ray, direction), way);
        const auto cage_of = [&](std::size_t i) -> const lod::PosedCage& {
            return *(met[i].grid ? met[i].grid : &any)->cage;
        };
        if (in_still == 0) place_all(rays, way, cage_of, origin);
        else place_in_still_poses(rays, cage_of);
    }

    /// Returns the radius of each ray's cage, by those of the cages as they are in their dicing frames.
    vfloat radius(const FloatLanes& of_cages) const noexcept
    {
        if (in_still == 0) return vfloat::load(of_cages);
        alignas(32) FloatLanes of;
        vfloat::load(of_cages).store(of);
        for_each_in_still([&](std::size_t i) { of[i] = still_radius_[i]; });
        return vfloat::load(of);
    }
    /// Returns the anchor of the cage that a lane has hit.
    const Vec3d& anchor_of(std::size_t lane) const noexcept
    {
        return in_still >> lane & 1 ? still[lane].pose.anchor : met_[lane].grid->cage->anchor;
    }
    /// Sets the positions of the corners, as HitCorners::set_positions() does.
    void set_positions(HitCorners& corners, unsigned coarse_starts) noexcept
    {
        const vfloat directions[3] = {way[0], way[1], way[2]}, origins[3] = {origin[0], origin[1], origin[2]};
        if (in_still == 0) return corners.set_positions(directions, origins, origin[3], coarse_starts);
        alignas(32) FloatLanes gradient[3], from[3], shift;
        for (int a = 0; a < 3; ++a) {
            directions[a].store(gradient[a]);
            origins[a].store(from[a]);
        }
        origin[3].store(shift);
        for_each_in_still([&](std::size_t i) {
            for (int a = 0; a < 3; ++a) {
                gradient[a][i] = still[i].gradient[a];
                from[a][i] = still[i].origin[a];
            }
            shift[i] = still[i].shift;
        });
        corners.set_positions({vfloat::load(gradient[0]), vfloat::load(gradient[1]), vfloat::load(gradient[2])},
                              {vfloat::load(from[0]), vfloat::load(from[1]), vfloat::load(from[2])}, vfloat::load(shift),
                              coarse_starts);
        set_still_shares(corners);
        for_each_in_still([&](std::size_t i) { corners.move_positions(i, still[i].pose); });
    }
    /// Puts the weights of the corners in those lanes whose cage is hit in a still pose; call it when positions are set. A
    /// ray hits there, in coordinates that are rounded otherwise than in the world, and an affine map keeps the weights.
    void put_still_shares(vfloat (&share)[3]) const noexcept
    {
        for (int p = 0; p < 3; ++p) {
            alignas(32) FloatLanes of;
            share[p].store(of);
            for_each_in_still([&](std::size_t i) { of[i] = still_share_[p][i]; });
            share[p] = vfloat::load(of);
        }
    }
    /// Takes the corners' normals from still poses to the world; call it when the attributes are set.
    void move_normals(HitCorners& corners) const noexcept
    {
        for_each_in_still([&](std::size_t i) { corners.move_normals(i, still[i].pose); });
    }
    /// Returns the velocity of a point of a lane that is hit in a still pose, per shutter.
    /// place   relative to the anchor
    Vec3f velocity_of(std::size_t lane, const lod::PosedCage& still_pose, float time, Vec3d place) const noexcept
    {
        const lod::AffinePose& pose = still[lane].pose;
        const Vec3d &a = pose.columns[0], &b = pose.columns[1], &c = pose.columns[2];
        const Vec3d bc = glm::cross(b, c);
        const Vec3d there = Vec3d(glm::dot(bc, place), glm::dot(glm::cross(c, a), place),
                                  glm::dot(glm::cross(a, b), place)) /
                            glm::dot(a, bc);
        const lod::AffinePose speed = still_pose.affine->speed_at(time);
        return Vec3f(speed.anchor + speed.apply(there));
    }

private:
    /// Sets still_share_ by corners that are still where they are in their still poses.
    void set_still_shares(const HitCorners& corners) noexcept;
    template <class Call>
    void for_each_in_still(Call&& call) const noexcept
    {
        for (unsigned left = in_still; left != 0; left &= left - 1) call(static_cast<std::size_t>(std::countr_zero(left)));
    }
    template <class CageOf>
    OCCAM_NEVER_INLINE void place_in_still_poses(std::span<const Ray> rays, const CageOf& cage_of) noexcept
    {
        Frame frames[kLanes];
        for (std::size_t i = 0; i < rays.size(); ++i) frames[i] = {cage_of(i).anchor, cage_of(i).radius};
        for_each_in_still([&](std::size_t i) {
            const lod::PosedCage& cage = cage_of(i);
            still[i] = AffineRay(rays[i], cage);
            still_radius_[i] = static_cast<float>(double(cage.radius) * cage.affine->stretch());
            frames[i] = {still[i].pose.anchor, still_radius_[i]};
        });
        place_all(
            rays, way, [&](std::size_t i) -> const Frame& { return frames[i]; }, origin);
    }

    std::span<const GridHit> met_;
    float still_radius_[kLanes];  ///< valid in the lanes in_still
    FloatLanes still_share_[3];   ///< the same, by corner
};

}  // namespace occam::accel
