// Finds where secondary rays start from the micropolygons that rays have hit, in lanes.
//
// Space    The dicing frame of the lane's cage.
#pragma once

#include <optional>

#include "accel/hit_geometry.h"

namespace occam::accel {

/// A secondary ray starts at this distance from its micropolygon, and keeps that far from its edges; both are in ulps of
/// the largest coordinate. The first is more than rounding moves the start by. With the second the start is also in
/// front of the next micropolygon, if that rises at 15 degrees or more against this one.
inline constexpr float kStartUlps = 16, kEdgeUlps = 64;

/// Holds the points where secondary rays start, in lanes: on the micropolygon as the start level has it, and away from its
/// edges, behind which another surface may begin at once. In a triangle that is too narrow for that, rays start from the
/// middle.
struct Starts {
    VecLanes corner, offset, normal;  ///< the point is corner + offset; the normal is unit, by winding, or zero

    Starts(const HitCorners& corners, const vfloat (&share)[3], vmask has_start, vmask is_gap, vfloat least_height) noexcept
    {
        const auto own = [&](const FloatLanes(&start)[3], const FloatLanes(&position)[3]) {
            const VecLanes p = load(start), q = load(position);
            return VecLanes{select(has_start, p.x, q.x), select(has_start, p.y, q.y), select(has_start, p.z, q.z)};
        };
        corner = own(corners.start[0], corners.position[0]);
        const VecLanes b = own(corners.start[1], corners.position[1]) - corner,
                       c = own(corners.start[2], corners.position[2]) - corner, a = c - b;
        normal = Triangles::unit_normal(b, c);
        const vfloat area = abs(dot(cross(b, c), normal)), third = 1.0f / 3, zero = 0.0f;
        vfloat inside[3], sum = zero;
        vmask is_near = is_gap;
        const VecLanes opposite[3] = {a, c, b};
        for (int p = 0; p < 3; ++p) {
            const vfloat least = min(select(area > zero, least_height * sqrt(dot(opposite[p], opposite[p])) / area, third),
                                     third);
            is_near = is_near | (share[p] < least);
            inside[p] = select(is_gap, third, max(share[p], least));
            sum = sum + inside[p];
        }
        const vfloat v = select(is_near, inside[1] / sum, share[1]), w = select(is_near, inside[2] / sum, share[2]);
        offset = b * v + c * w;
    }
};

/// Holds the starts of those lanes in which secondary rays do not simply start from the hit.
struct StartsBesideHits {
    unsigned which = 0;  ///< bit mask of these lanes
    std::optional<Starts> starts;

    /// farthest   the largest coordinate at the hit
    StartsBesideHits(const HitCorners& corners, const Triangles& tri, const vfloat (&share)[3], vmask is_flat,
                     vfloat farthest) noexcept
    {
        const vfloat least_height = vfloat(kEdgeUlps * FLT_EPSILON) * farthest;
        const vfloat nearest = min(min(share[0], share[1]), share[2]),
                     longest_edge = max(largest(tri.edge[0]), largest(tri.edge[1]));
        which = corners.has_start | bits(nearest * tri.area < vfloat(4.0f) * least_height * longest_edge);
        if (which == 0) return;
        alignas(32) FloatLanes has_start;
        for (unsigned lane = 0; lane < kLanes; ++lane) has_start[lane] = corners.has_start >> lane & 1 ? 1.0f : 0.0f;
        starts.emplace(corners, share, vfloat::load(has_start) > vfloat(0.0f), is_flat, least_height);
    }
    /// Returns the offsets from the hits to the starts; `offset` leads from corner a to the hit, and is returned where there
    /// are no starts.
    VecLanes from_hits(const HitCorners& corners, const VecLanes& offset) const noexcept
    {
        return starts ? (starts->corner - load(corners.position[0])) + (starts->offset - offset) : offset;
    }
};

}  // namespace occam::accel
