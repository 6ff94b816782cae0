// Implements the watertight ray/triangle test in lanes: rays against one triangle, or one ray against many.
//
// It follows Woop et al. 2013. Edge functions are not fused, and zero counts as inside: a - b of two rounded products
// has the right sign or is zero, and swapping the ends of an edge negates it exactly, so no ray passes between two
// triangles with the same vertex bits (measured against fused forms: docs/watertightness.md). det = 0 is a miss. t is
// clamped to where the ray is in the triangle's own box (see Extent and narrowed()).
#pragma once

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cstddef>
#include <limits>

#include "accel/ray_lanes.h"

namespace occam::accel {

/// Holds a vertex in a ray's sheared frame: the ray is the line x = y = 0, and t is the distance along it.
struct ShearedVertex {
    vfloat x, y, t;
};

/// Shears a point into the ray's frame. The coordinates of p and of the origin are along the ray's kx, ky, kz.
OCCAM_ALWAYS_INLINE ShearedVertex shear(const RayLanes& ray, const VecLanes& origin, const VecLanes& p) noexcept
{
    const vfloat z = p.z - origin.z;
    return {fnma(ray.sx, z, p.x - origin.x), fnma(ray.sy, z, p.y - origin.y), ray.sz * z};
}

struct TriangleHit {
    vmask is_hit;
    vfloat t;
    vmask is_rough{false};           ///< t may be off by more than its own rounding (see narrowed())
    vfloat spread{0.0f}, det{0.0f};  ///< t may be off by as many ulps of 1 as spread / |det| says
};

/// Holds the edge functions of a triangle: u belongs to the vertex a (and is zero on b c), and so on.
struct EdgeFunctions {
    vfloat u, v, w;
};
OCCAM_ALWAYS_INLINE EdgeFunctions edge_functions(const ShearedVertex& a, const ShearedVertex& b,
                                                 const ShearedVertex& c) noexcept
{
    return {c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x};
}
OCCAM_ALWAYS_INLINE vmask is_inside(const EdgeFunctions& e) noexcept
{
    const vfloat zero = 0.0f;
    return ((e.u >= zero) & (e.v >= zero) & (e.w >= zero)) | ((e.u <= zero) & (e.v <= zero) & (e.w <= zero));
}

/// Returns hits, whose t is valid in the lanes `inside`.
OCCAM_ALWAYS_INLINE TriangleHit hit_inside(const RayLanes& ray, const EdgeFunctions& e, vmask inside, const ShearedVertex& a,
                                           const ShearedVertex& b, const ShearedVertex& c) noexcept
{
    const vfloat det = (e.u + e.v) + e.w;
    const vfloat t = ((e.u * a.t + e.v * b.t) + e.w * c.t) / det;
    const vfloat low = min(min(a.t, b.t), c.t), high = max(max(a.t, b.t), c.t), clamped = min(max(t, low), high);
    // The edge functions are off by an ulp of x y each, and t by as large a share of its extent. Boxes allow for four ulps
    // of t (accel/in_box.h), of which this may take two.
    const vfloat x = max(max(abs(a.x), abs(b.x)), abs(c.x)), y = max(max(abs(a.y), abs(b.y)), abs(c.y));
    const vfloat spread = (x * y) * (high - low) * vfloat(1.5f);
    return {andnot(inside, det == vfloat(0.0f)), ray.shift + clamped, spread > abs(det) * abs(clamped), spread, det};
}

OCCAM_ALWAYS_INLINE TriangleHit intersect(const RayLanes& ray, const ShearedVertex& a, const ShearedVertex& b,
                                          const ShearedVertex& c) noexcept
{
    const EdgeFunctions e = edge_functions(a, b, c);
    const vmask inside = is_inside(e);
    if (none(inside)) return {inside, 0.0f};
    return hit_inside(ray, e, inside, a, b, c);
}

/// Holds where rays are in the box of a triangle, as far as its coordinates along kx and ky say; hit_inside() sees to those
/// along kz. The error of t grows with the square of a sliver's length over its width, and a hit before or behind its box
/// would be found or not depending on what was found earlier: that decides which boxes a ray enters. The bounds are
/// computed as those of boxes are (accel/in_box.h), so they are within those of any box that holds the triangle.
struct Extent {
    vfloat low, high;

    /// The coordinates of the corners and of the origin are along the ray's kx, ky, kz.
    Extent(const RayLanes& ray, const VecLanes& origin, const VecLanes& a, const VecLanes& b, const VecLanes& c) noexcept
        : low(-FLT_MAX), high(FLT_MAX)
    {
        narrow(min(min(a.x, b.x), c.x) - origin.x, max(max(a.x, b.x), c.x) - origin.x, ray.inverse[ray.kx]);
        narrow(min(min(a.y, b.y), c.y) - origin.y, max(max(a.y, b.y), c.y) - origin.y, ray.inverse[ray.ky]);
        low = ray.shift + low;
        high = ray.shift + high;
    }
    vfloat narrowed(vfloat t) const noexcept { return min(max(t, low), high); }

private:
    void narrow(vfloat least, vfloat most, vfloat inverse) noexcept
    {
        // A ray along the planes of the axis may be there at any t.
        const vmask crosses = abs(inverse) < vfloat(0.5f / kLeastDirection);
        const vfloat first = least * inverse, last = most * inverse;
        low = select(crosses, max(low, min(first, last)), low);
        high = select(crosses, min(high, max(first, last)), high);
    }
};

/// Returns t with the lanes `which` replaced by where rays meet the planes of their triangles, computed in double. A ray
/// along a plane keeps its t.
OCCAM_NEVER_INLINE inline vfloat on_planes(const RayLanes& ray, const VecLanes& origin, const VecLanes (&corners)[3],
                                           unsigned which, vfloat t) noexcept
{
    FloatLanes at[3][3], from[3], shear_x, shear_y, per_z, shift, result;
    for (int p = 0; p < 3; ++p) store(corners[p], at[p]);
    store(origin, from);
    ray.sx.store(shear_x);
    ray.sy.store(shear_y);
    ray.sz.store(per_z);
    ray.shift.store(shift);
    t.store(result);
    for (; which != 0; which &= which - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(which));
        const auto point = [&](int p) {
            return Vec3d(at[p][0][lane], at[p][1][lane], at[p][2][lane]) -
                   Vec3d(from[0][lane], from[1][lane], from[2][lane]);
        };
        const Vec3d a = point(0), b = point(1), c = point(2), normal = glm::cross(b - a, c - a);
        const double along = normal.x * double(shear_x[lane]) + normal.y * double(shear_y[lane]) + normal.z;
        if (along == 0) continue;
        const double z = std::clamp(glm::dot(normal, a) / along, std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z}));
        result[lane] = shift[lane] + static_cast<float>(z * double(per_z[lane]));
    }
    return vfloat::load(result);
}

/// The t of what seems to be a hit and is none: no interval of a ray holds it.
inline constexpr float kNoT = -std::numeric_limits<float>::infinity();

/// Returns which rays pass the boxes of triangles, which are grown and tested as those of igrids are (accel/in_box.h): a ray
/// that passes the triangle's box passes all boxes that hold it. Where a ray lies in a triangle's plane, the edge functions
/// are rounding errors of any signs, and seem to be those of a hit far beside the ray.
inline vmask passes_box(const RayLanes& ray, const VecLanes& origin, const VecLanes& a, const VecLanes& b,
                        const VecLanes& c) noexcept
{
    const vfloat pad = max(max(largest(a), largest(b)), largest(c)) * vfloat(2 * FLT_EPSILON);
    vfloat in = -FLT_MAX, out = FLT_MAX;
    const auto cross = [&](vfloat low, vfloat high, vfloat from, vfloat inverse) {
        const vfloat first = (low - pad - from) * inverse, last = (high + pad - from) * inverse;
        in = max(in, min(first, last));
        out = min(out, max(first, last));
    };
    cross(min(min(a.x, b.x), c.x), max(max(a.x, b.x), c.x), origin.x, ray.inverse[ray.kx]);
    cross(min(min(a.y, b.y), c.y), max(max(a.y, b.y), c.y), origin.y, ray.inverse[ray.ky]);
    cross(min(min(a.z, b.z), c.z), max(max(a.z, b.z), c.z), origin.z, ray.inverse[ray.kz]);
    const vfloat slack = 4 * FLT_EPSILON;
    return in - (abs(in) + abs(ray.shift)) * slack <= out + (abs(out) + abs(ray.shift)) * slack;
}

/// Returns the t of a hit. Where it is rough, it is within the extent of the triangle, or kNoT if the ray passes beside the
/// triangle's box. corner(0) to corner(2) return the corners, which are read again: few hits are rough. Where t may be off
/// by more than the coordinates of the origin are, it is computed again in double: a ray that starts next to a sliver would
/// hit it from the wrong side.
template <class Corner>
OCCAM_NEVER_INLINE vfloat narrowed_where_rough(const RayLanes& ray, const VecLanes& origin, const TriangleHit& hit,
                                               const Corner& corner) noexcept
{
    const VecLanes a = corner(0), b = corner(1), c = corner(2);
    const vfloat least = abs(hit.det) * largest(origin);
    const unsigned wrong = bits(hit.is_hit & hit.is_rough & (hit.spread > least));
    const vfloat t = wrong != 0 ? on_planes(ray, origin, {a, b, c}, wrong, hit.t) : hit.t;
    const vfloat inside = select(passes_box(ray, origin, a, b, c), Extent(ray, origin, a, b, c).narrowed(t), kNoT);
    return select(hit.is_rough, inside, t);
}
template <class Corner>
OCCAM_ALWAYS_INLINE vfloat narrowed(const RayLanes& ray, const VecLanes& origin, const TriangleHit& hit,
                                    const Corner& corner) noexcept
{
    return none(hit.is_hit & hit.is_rough) ? hit.t : narrowed_where_rough(ray, origin, hit, corner);
}

/// Holds the side of the edge from p to q on which the ray passes; on the edge the value is 0. It is computed as in
/// edge_functions(), and the value for q to p is exactly the opposite.
struct Edge {
    vfloat side;
    vmask is_left, is_right;  ///< both are set on the edge

    Edge() = default;
    OCCAM_ALWAYS_INLINE Edge(const ShearedVertex& p, const ShearedVertex& q) noexcept
        : side(p.x * q.y - p.y * q.x), is_left(side >= vfloat(0.0f)), is_right(side <= vfloat(0.0f))
    {
    }
};

/// Refers to the vertices of a quad; the first index is that along u.
struct QuadVertices {
    const ShearedVertex &v00, &v10, &v01, &v11;
};

/// Refers to the edges of a quad: left and right run from the lower vertex to the upper one, low and high run from the right
/// vertex to the left one.
struct QuadEdges {
    const Edge &left, &right, &low, &high;
};

/// Intersects the two triangles of a quad, (v00, v10, v11) and (v00, v11, v01). Their edges are computed once, as are
/// those that quads share; the bits are those of intersect(). take(hit, triangle) is called for triangles that some lane has
/// hit.
template <class Take>
OCCAM_ALWAYS_INLINE void intersect_quad(const RayLanes& ray, const QuadVertices& vertices, const QuadEdges& edges,
                                        Take&& take) noexcept
{
    const auto& [v00, v10, v01, v11] = vertices;
    const auto& [left, right, low, high] = edges;
    const Edge diagonal(v00, v11);
    const vmask first = (right.is_right & diagonal.is_left & low.is_left) |
                        (right.is_left & diagonal.is_right & low.is_right);
    const vmask second = (high.is_right & left.is_left & diagonal.is_right) |
                         (high.is_left & left.is_right & diagonal.is_left);
    if (none(first | second)) return;
    if (any(first)) take(hit_inside(ray, {-right.side, diagonal.side, low.side}, first, v00, v10, v11), 0);
    if (any(second)) take(hit_inside(ray, {-high.side, left.side, -diagonal.side}, second, v00, v11, v01), 1);
}

}  // namespace occam::accel
