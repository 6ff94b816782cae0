// Decides which side is the outside of micropolygons that blending has turned over: their vertices move past each other
// between two levels, and their normal is opposite to those that they have in both.
//
// Such a micropolygon may lie in a fold of the mesh, where its winding is right, or in a loop that hangs into the room,
// where its outside is opposite. A ray that has passed no surface is still on the side of the cage on which it started,
// which tells the two apart. For other rays the winding counts.
#pragma once

#include <bit>

#include "accel/hit_rays.h"

namespace occam::accel {

/// Holds what is known of the hits of some rays, in lanes.
struct TurnedOver {
    HitCorners& corners;
    const HitRays& placed;
    unsigned gaps;           ///< lanes that met gap triangles
    unsigned coarse_starts;  ///< lanes whose start is in the mesh of the coarser level
    const VecLanes& normal;  ///< of what was hit, by winding

    /// Orients the lanes whose micropolygon is turned over by the sides on which their rays have started, where these are
    /// known.
    ///
    /// at_start      the normals in the mesh of the start
    /// orientation   becomes 1, or -1 where the outside is opposite to the normal by winding
    void orient(std::span<const Ray> rays, std::span<const GridHit> met, const VecLanes& at_start,
                FloatLanes& orientation) const noexcept
    {
        unsigned left = corners.has_start & ~gaps & bits(dot(normal, at_start) < vfloat(0.0f));
        for (; left != 0; left &= left - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(left));
            const Ray& ray = rays[i];
            if (ray.t_near > 0 || (ray.start_side ^ side_name(met[i].grid->cage->path.hash, false)) > 1) continue;
            const Vec3f by_winding = Stored(normal)[i];
            if (!is_opposite_at_other_end(i, by_winding)) continue;
            const bool leads_out = glm::dot(by_winding, ray.direction) > 0, is_inside = (ray.start_side & 1) != 0;
            orientation[i] = leads_out == is_inside ? 1.0f : -1.0f;
        }
    }

private:
    // One that is tilted by more than a right angle between the levels is opposite to one of its ends alone.
    OCCAM_NEVER_INLINE bool is_opposite_at_other_end(std::size_t lane, Vec3f by_winding) const noexcept
    {
        HitCorners::Corners other = corners.at_level(lane, (coarse_starts >> lane & 1) == 0);
        if (placed.in_still >> lane & 1)
            for (Vec3f& corner : other.of) corner = Vec3f(placed.still[lane].pose.apply(corner));
        const Vec3d a(other.of[0]), b(other.of[1]), c(other.of[2]);
        return glm::dot(glm::cross(b - a, c - a), Vec3d(by_winding)) < 0;
    }
};

}  // namespace occam::accel
