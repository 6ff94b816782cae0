#include "accel/hit_shares.h"

#include <bit>

#include "accel/triangle.h"

namespace occam::accel {
namespace {

// Computes the barycentrics of the point where the ray meets the plane of a gap triangle, clamped to the triangle; in
// double, since the triangle has no area.
Vec3d barycentrics(const HitCorners& corners, std::size_t lane, Vec3d origin, Vec3d direction) noexcept
{
    const auto from_origin = [&](int corner) { return Vec3d(corners.position_of(corner, lane)) - origin; };
    const Vec3d a = from_origin(0), b = from_origin(1), c = from_origin(2);
    Vec3d w{glm::dot(direction, glm::cross(c, b)), glm::dot(direction, glm::cross(a, c)),
            glm::dot(direction, glm::cross(b, a))};
    const double sum = w.x + w.y + w.z;
    if (sum == 0) return Vec3d(1.0 / 3);
    w *= 1 / sum;
    if (w.x >= 0 && w.y >= 0 && w.z >= 0) return w;
    w = glm::max(w, Vec3d(0));
    return w / (w.x + w.y + w.z);
}

// Computes the barycentric weights of the corners at the hit, from the same edge functions that found the hit.
void set_shares(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    const RayAxes& axes = hit.axes;
    vfloat shears[3];
    set_shear(axes, hit.placed.way, shears);
    RayLanes rays;
    rays.sx = shears[0];
    rays.sy = shears[1];
    rays.sz = shears[2];
    const VecLanes from{hit.placed.origin[axes.kx], hit.placed.origin[axes.ky], hit.placed.origin[axes.kz]};
    const auto corner = [&](int p) {
        const FloatLanes(&at)[3] = corners.position[p];
        return shear(rays, from, {vfloat::load(at[axes.kx]), vfloat::load(at[axes.ky]), vfloat::load(at[axes.kz])});
    };
    const EdgeFunctions edges = edge_functions(corner(0), corner(1), corner(2));
    const vfloat zero = 0.0f, det = (edges.u + edges.v) + edges.w;
    const vmask has_area = (det > zero) | (det < zero);
    const vfloat of[3] = {edges.u, edges.v, edges.w};
    for (int p = 0; p < 3; ++p) share[p] = select(has_area, max(of[p] / det, zero), 1.0f / 3);
}

// Does the same for gap triangles, which have no edge functions.
OCCAM_NEVER_INLINE void set_shares_of_gaps(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    alignas(32) FloatLanes own[3];
    for (int p = 0; p < 3; ++p) share[p].store(own[p]);
    for (unsigned left = hit.gaps; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        const Vec3d w = barycentrics(corners, i, hit.rays[i].origin - hit.placed.anchor_of(i), Vec3d(hit.rays[i].direction));
        for (int p = 0; p < 3; ++p) own[p][i] = static_cast<float>(w[p]);
    }
    for (int p = 0; p < 3; ++p) share[p] = vfloat::load(own[p]);
}

}  // namespace

void shares_of(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    set_shares(corners, hit, share);
    if (hit.gaps != 0) set_shares_of_gaps(corners, hit, share);
}

}  // namespace occam::accel
