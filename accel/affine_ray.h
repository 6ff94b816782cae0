// A ray that is taken to the still pose of a cage that moves by its nodes alone (lod/affine_motion.h).
//
// The direction is not normalised, so t is that of the ray in the world. All is computed in double and rounded once, from
// the ray and the cage alone: so each igrid of the cage sees the same ray, whether it travels alone or in a packet.
#pragma once

#include "accel/ray_lanes.h"
#include "lod/posed_cage.h"

namespace occam::accel {

struct AffineRay {
    lod::AffinePose pose;  ///< at the ray's time
    RayAxes axes;
    float origin[3], shift, direction[3];
    float gradient[3];  ///< of t over points of the still pose

    AffineRay() = default;
    AffineRay(const Ray& ray, const lod::PosedCage& still_pose) noexcept : pose(still_pose.affine->at(ray.time))
    {
        if (const lod::AffineInverse* fixed = still_pose.affine->fixed_inverse()) set(ray, still_pose, *fixed);
        else set(ray, still_pose, lod::AffineInverse(pose));
    }

    /// Returns the ray in all lanes, without its blend.
    RayLanes lanes() const noexcept
    {
        RayLanes all;
        all.kx = axes.kx;
        all.ky = axes.ky;
        all.kz = axes.kz;
        float shear[3], per_length[3];
        set_shear(axes, direction, shear);
        set_inverse(axes, direction, per_length);
        all.sx = shear[0];
        all.sy = shear[1];
        all.sz = shear[2];
        for (int k = 0; k < 3; ++k) {
            all.inverse[k] = per_length[k];
            all.origin[k] = origin[k];
        }
        all.shift = shift;
        return all;
    }

private:
    OCCAM_ALWAYS_INLINE void set(const Ray& ray, const lod::PosedCage& still_pose,
                                 const lod::AffineInverse& inverse) noexcept
    {
        const Vec3d way(ray.direction), d = inverse.apply(way);
        Vec3d from = inverse.apply(ray.origin - pose.anchor);
        // As in place(), an origin that is far away is moved along the ray to near the cage.
        const double squared = glm::dot(d, d), along = -glm::dot(from, d), near = double(kNearRadii) * still_pose.radius;
        shift = 0;
        if (along > 0 && along * along > near * near * squared) {
            shift = static_cast<float>(along / squared);
            from += d * double(shift);
        }
        for (int k = 0; k < 3; ++k) {
            origin[k] = static_cast<float>(from[k]);
            direction[k] = static_cast<float>(d[k]);
            gradient[k] = static_cast<float>(glm::dot(way, pose.columns[k]));
        }
        axes = RayAxes(RayAxes::group_of(direction));
    }
};

}  // namespace occam::accel
