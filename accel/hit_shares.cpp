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

// Holds rays and corners of micropolygons, with coordinates along each ray's kx, ky, kz.
struct AlongRays {
    vfloat shear[3];
    VecLanes origin, corner[3];
};

// Computes the barycentric weights of the corners at the hit, from the same edge functions that found the hit.
OCCAM_ALWAYS_INLINE void set_shares(const AlongRays& of, vfloat (&share)[3]) noexcept
{
    RayLanes rays;
    rays.sx = of.shear[0];
    rays.sy = of.shear[1];
    rays.sz = of.shear[2];
    const auto corner = [&](int p) { return shear(rays, of.origin, of.corner[p]); };
    const EdgeFunctions edges = edge_functions(corner(0), corner(1), corner(2));
    const vfloat zero = 0.0f, det = (edges.u + edges.v) + edges.w;
    const vmask has_area = (det > zero) | (det < zero);
    const vfloat of_corner[3] = {edges.u, edges.v, edges.w};
    for (int p = 0; p < 3; ++p) share[p] = select(has_area, max(of_corner[p] / det, zero), 1.0f / 3);
}

void set_shares(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    const RayAxes& axes = hit.axes;
    AlongRays along;
    set_shear(axes, hit.placed.way, along.shear);
    along.origin = {hit.placed.origin[axes.kx], hit.placed.origin[axes.ky], hit.placed.origin[axes.kz]};
    for (int p = 0; p < 3; ++p) {
        const FloatLanes(&at)[3] = corners.position[p];
        along.corner[p] = {vfloat::load(at[axes.kx]), vfloat::load(at[axes.ky]), vfloat::load(at[axes.kz])};
    }
    set_shares(along, share);
}

// Does the same for gap triangles that are hit in the world, which have no edge functions.
OCCAM_NEVER_INLINE void set_shares_of_gaps(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    alignas(32) FloatLanes own[3];
    for (int p = 0; p < 3; ++p) share[p].store(own[p]);
    for (unsigned left = hit.gaps & ~hit.placed.in_still; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        const Vec3d w = barycentrics(corners, i, hit.rays[i].origin - hit.placed.anchor_of(i), Vec3d(hit.rays[i].direction));
        for (int p = 0; p < 3; ++p) own[p][i] = static_cast<float>(w[p]);
    }
    for (int p = 0; p < 3; ++p) share[p] = vfloat::load(own[p]);
}

}  // namespace

OCCAM_NEVER_INLINE void HitRays::set_still_shares(const HitCorners& corners) noexcept
{
    // Each ray has axes of its own there.
    alignas(32) FloatLanes sheared[3]{}, from[3]{}, at[3][3]{};
    for_each_in_still([&](std::size_t i) {
        const AffineRay& ray = still[i];
        const int axes[3] = {ray.axes.kx, ray.axes.ky, ray.axes.kz};
        float own[3];
        set_shear(ray.axes, ray.direction, own);
        for (int a = 0; a < 3; ++a) {
            sheared[a][i] = own[a];
            from[a][i] = ray.origin[axes[a]];
            for (int p = 0; p < 3; ++p) at[p][a][i] = corners.position[p][axes[a]][i];
        }
    });
    AlongRays along;
    for (int a = 0; a < 3; ++a) along.shear[a] = vfloat::load(sheared[a]);
    along.origin = load(from);
    for (int p = 0; p < 3; ++p) along.corner[p] = load(at[p]);
    vfloat share[3];
    set_shares(along, share);
    for (int p = 0; p < 3; ++p) share[p].store(still_share_[p]);
    for_each_in_still([&](std::size_t i) {
        if (!is_gap(met_[i])) return;
        const auto vector = [](const float(&v)[3]) { return Vec3d(v[0], v[1], v[2]); };
        const Vec3d w = barycentrics(corners, i, vector(still[i].origin), vector(still[i].direction));
        for (int p = 0; p < 3; ++p) still_share_[p][i] = static_cast<float>(w[p]);
    });
}

void shares_of(const HitCorners& corners, const RaysThatHit& hit, vfloat (&share)[3]) noexcept
{
    set_shares(corners, hit, share);
    if (hit.gaps != 0) set_shares_of_gaps(corners, hit, share);
    if (hit.placed.in_still != 0) hit.placed.put_still_shares(share);
}

}  // namespace occam::accel
