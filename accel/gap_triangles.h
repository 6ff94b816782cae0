// Intersects the gap triangles of T-vertices, which have no area, with one ray.
#pragma once

#include <algorithm>
#include <bit>

#include "accel/coordinates.h"
#include "accel/igrid.h"
#include "accel/triangle.h"

namespace occam::accel {

/// Holds the part of each ray that can hit an igrid, in lanes (for a single ray, in all lanes).
struct RaySpan {
    vfloat t_near, t_end;
};

/// Holds a ray of a query, and what is read for it, in all lanes.
template <class Coordinates>
struct OneRay {
    int lane;
    const RayLanes& ray;
    const VecLanes& origin;    ///< along kx, ky, kz
    const VertexBlend& blend;  ///< along the same axes
    Coordinates read;
};

/// Holds the gap triangles of an igrid. Query is as in igrid_intersect.h.
template <class Query, class Coordinates>
struct GapTriangles {
    LatticeGrid& grid;
    const float* const* fine;  ///< coordinates along kx, ky, kz, at the rays' key
    const float* const* coarse;
    const float* const* still;  ///< `fine` or `coarse`: the positions where nothing is blended
    const RaySpan& span;
    Query& query;

    /// Intersects the gap triangles of T-vertices, which have no area. The float test decides no hit here: its signs
    /// are right, but its t is noise along the edge. What it lets through is tested again in double, where products of
    /// floats are exact (watertightness rule 6).
    OCCAM_NEVER_INLINE void intersect(int block, const OneRay<Coordinates>& one, bool blends) const noexcept
    {
        const RayLanes& ray = one.ray;
        for (int first = block * IGrid::kBlock; first < (block + 1) * IGrid::kBlock; first += kLanes) {
            float end[2][3][kLanes], corner[3][3][kLanes];
            ShearedVertex sheared[2];
            for (int e = 0; e < 2; ++e) {
                const auto gather = [&](const float* const* p) {
                    // At the key, and at the next one.
                    float lanes[Coordinates::kMove ? 2 : 1][3][kLanes];
                    for (int k = 0; k < kLanes; ++k) {
                        const lod::Hanging& hanging = grid.hanging[static_cast<std::size_t>(first + k)];
                        const std::uint32_t vertex = e == 0 ? hanging.a : hanging.c;
                        for (int a = 0; a < 3; ++a) {
                            lanes[0][a][k] = p[a][vertex];
                            if constexpr (Coordinates::kMove) lanes[1][a][k] = p[a][vertex + grid.floats_of_a_key];
                        }
                    }
                    const auto coordinates = [&](int a) { return one.read.many(lanes[0][a], 3 * kLanes); };
                    return VecLanes{coordinates(0), coordinates(1), coordinates(2)};
                };
                const VecLanes p = blends ? one.blend.between(gather(fine), gather(coarse)) : gather(still);
                p.x.store(end[e][0]);
                p.y.store(end[e][1]);
                p.z.store(end[e][2]);
                sheared[e] = shear(ray, one.origin, p);
            }
            if (none(may_be_on(sheared[0], sheared[1]))) continue;
            for (int k = 0; k < kLanes; ++k) {
                const lod::Hanging::Ends ends = grid.hanging[static_cast<std::size_t>(first + k)].on(
                    {end[0][0][k], end[0][1][k], end[0][2][k]}, {end[1][0][k], end[1][1][k], end[1][2][k]});
                for (int a = 0; a < 3; ++a) {
                    corner[0][a][k] = ends.low[a];
                    corner[1][a][k] = ends.middle[a];
                    corner[2][a][k] = ends.high[a];
                }
            }
            ShearedVertex v[3];
            VecLanes at[3];
            for (int p = 0; p < 3; ++p) {
                at[p] = {vfloat::load(corner[p][0]), vfloat::load(corner[p][1]), vfloat::load(corner[p][2])};
                v[p] = shear(ray, one.origin, at[p]);
            }
            const unsigned inside = bits(is_inside(edge_functions(v[0], v[1], v[2])));
            if (inside != 0) offer_exact(one, v, Extent(ray, one.origin, at[0], at[1], at[2]), inside, first);
        }
    }

private:
    /// Tests the triangles of some lanes again in double, and offers the hits. `first` is the number of lane 0.
    void offer_exact(const OneRay<Coordinates>& one, const ShearedVertex (&v)[3], const Extent& extent, unsigned lanes,
                     int first) const noexcept
    {
        float x[3][kLanes], y[3][kLanes], t[3][kLanes], shift[kLanes], t_near[kLanes], t_far[kLanes], low[kLanes],
            high[kLanes];
        extent.low.store(low);
        extent.high.store(high);
        for (int p = 0; p < 3; ++p) {
            v[p].x.store(x[p]);
            v[p].y.store(y[p]);
            v[p].t.store(t[p]);
        }
        one.ray.shift.store(shift);
        span.t_near.store(t_near);
        for (; lanes != 0; lanes &= lanes - 1) {
            const int k = std::countr_zero(lanes);
            const auto area = [&](int p, int q) { return double(x[q][k]) * y[p][k] - double(y[q][k]) * x[p][k]; };
            const double u = area(1, 2), w_v = area(2, 0), w = area(0, 1);
            const bool inside = (u >= 0 && w_v >= 0 && w >= 0) || (u <= 0 && w_v <= 0 && w <= 0);
            const double det = u + w_v + w;
            if (!inside || det == 0) continue;
            const double exact = (u * t[0][k] + w_v * t[1][k] + w * t[2][k]) / det;
            const float found = std::min(std::max(shift[0] + static_cast<float>(exact), low[k]), high[k]);
            min(query.limit(), span.t_end).store(t_far);
            if (found > t_near[one.lane] && found <= t_far[one.lane])
                query.offer(one.lane, found, grid, kGapBit | static_cast<std::uint32_t>(first + k));
        }
    }
    /// Returns whether the ray may hit a triangle whose corners lie on the line from a to c. The test allows for the
    /// rounding of the midpoints of some ten halvings and of the shear, for coordinates of up to five radii (see
    /// place()).
    vmask may_be_on(const ShearedVertex& a, const ShearedVertex& c) const noexcept
    {
        const vfloat off = grid.cage->radius * 0x1p-16f;
        const vfloat left = a.x * c.y, right = a.y * c.x;
        const vfloat slack = off * (abs(c.x - a.x) + abs(c.y - a.y)) + (abs(left) + abs(right)) * vfloat(0x1p-21f);
        return (min(a.x, c.x) <= off) & (max(a.x, c.x) >= -off) & (min(a.y, c.y) <= off) & (max(a.y, c.y) >= -off) &
               (abs(left - right) <= slack);
    }
};

}  // namespace occam::accel
