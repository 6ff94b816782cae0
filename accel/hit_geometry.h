// Computes the shape of the triangles that rays have hit, in lanes: normals, curvature, and the axes of texture
// coordinates.
//
// Edges are differences of neighbouring vertices, so floats hold them to a few ulps. Products are scaled so that they
// never underflow.
#pragma once

#include <cfloat>

#include "accel/corners.h"

namespace occam::accel {

/// Holds triangles in lanes. Their edges are b - a and c - a.
struct Triangles {
    VecLanes edge[2];
    VecLanes normal;  ///< unit length, by winding; 0 if the triangle has no area
    vfloat area;      ///< area of the parallelogram
    /// The gradients of the weights of b and c over the triangle, per world length. The gradients of all three weights add
    /// up to zero.
    VecLanes gradient[2];
    VecLanes way[2];  ///< the same, scaled for precision: only the directions count

    /// Computes the shape of the triangle between the edges b and c. Two edges of length zero give no shape.
    static VecLanes unit_normal(const VecLanes& b, const VecLanes& c) noexcept
    {
        const vfloat size = max(largest(b), largest(c));
        const vfloat scale = select(size > vfloat(0.0f), vfloat(1.0f) / size, 0.0f);
        const VecLanes across = cross(b * scale, c * scale);
        const vfloat length = sqrt(dot(across, across));
        return across * select(length > vfloat(0.0f), vfloat(1.0f) / length, 0.0f);
    }

    explicit Triangles(const HitCorners& corners) noexcept
    {
        const VecLanes a = load(corners.position[0]);
        edge[0] = load(corners.position[1]) - a;
        edge[1] = load(corners.position[2]) - a;
        // The edges are scaled to a length of at most one, so that no product underflows.
        const vfloat size = max(largest(edge[0]), largest(edge[1]));
        const vfloat scale = select(size > vfloat(0.0f), vfloat(1.0f) / size, 0.0f);
        const VecLanes e = edge[0] * scale, f = edge[1] * scale;
        const VecLanes across = cross(e, f);
        const vfloat length = sqrt(dot(across, across));
        const vfloat inverse = select(length > vfloat(0.0f), vfloat(1.0f) / length, 0.0f);
        normal = across * inverse;
        area = length * size * size;
        way[0] = cross(f, normal);
        way[1] = cross(normal, e);
        const vfloat per_length = inverse * scale;
        gradient[0] = way[0] * per_length;
        gradient[1] = way[1] * per_length;
    }
};

/// Returns half the divergence of the interpolated unit normal: the mean curvature, positive where the outside is
/// convex.
inline vfloat outward_curvature(const Triangles& tri, const VecLanes (&normal)[3]) noexcept
{
    VecLanes n[3];
    vmask known(true);
    for (int p = 0; p < 3; ++p) {
        const vfloat squared = dot(normal[p], normal[p]);
        known = known & (squared > vfloat(0.0f));
        n[p] = normal[p] * (vfloat(1.0f) / sqrt(squared));
    }
    return select(known, vfloat(0.5f) * (dot(n[1] - n[0], tri.gradient[0]) + dot(n[2] - n[0], tri.gradient[1])), 0.0f);
}

/// Holds the unit normals at hits, in lanes: of the micropolygon and interpolated, both towards the ray's origin.
struct NormalLanes {
    VecLanes corner[3];  ///< the corners' own, outward; unit, or 0; valid if any corner has one
    VecLanes geometric, shading;
    vmask is_back;  ///< the ray came from behind the face

    /// share         weights of the corners at the hits
    /// orientation   1, or -1 where the outside is opposite to the normal by winding: the cage's placement reverses the
    ///               orientation of faces, or the micropolygon is turned over
    NormalLanes(const HitCorners& corners, const Triangles& tri, const vfloat (&share)[3], vfloat orientation, vmask is_flat,
                const VecLanes& direction) noexcept
    {
        const vfloat zero = 0.0f, one = 1.0f;
        vmask is_smooth(false);
        shading = {zero, zero, zero};
        // A mesh need not have normals at its vertices.
        if (corners.has_normals != 0) {
            for (int p = 0; p < 3; ++p) {
                vfloat axes_of[4];
                load(corners.normal[p], axes_of);
                corner[p] = {axes_of[0], axes_of[1], axes_of[2]};
            }
            const VecLanes mixed = corner[0] * share[0] + corner[1] * share[1] + corner[2] * share[2];
            const vfloat longest = largest(mixed);
            is_smooth = longest > vfloat(1e-20f);
            const VecLanes scaled = mixed * select(is_smooth, one / longest, zero);
            shading = scaled * select(is_smooth, one / sqrt(dot(scaled, scaled)), zero);
        }
        // A gap triangle has no area, and a degenerate patch corner has no normal: one stands in for the other.
        const vmask has_normal = andnot(tri.area > zero, is_flat);
        geometric = select(has_normal, tri.normal * orientation, select(is_smooth, shading, -direction));
        shading = select(is_smooth, shading, geometric);
        is_back = dot(geometric, direction) > zero;
        geometric = select(is_back, -geometric, geometric);
        shading = select(dot(shading, geometric) < zero, -shading, shading);
    }
};

/// Holds texture coordinates in lanes: those of corner a, and their differences to b and c.
struct UvLanes {
    vfloat at[2], edge[2][2];  ///< axis; corner b or c, axis
    UvLanes() noexcept
    {
        for (int a = 0; a < 2; ++a) at[a] = edge[0][a] = edge[1][a] = 0.0f;
    }
    explicit UvLanes(const LaneFours (&uv)[3]) noexcept
    {
        vfloat of[3][4];
        for (int p = 0; p < 3; ++p) load(uv[p], of[p]);
        for (int a = 0; a < 2; ++a) {
            at[a] = of[0][a];
            for (int p = 0; p < 2; ++p) edge[p][a] = of[p + 1][a] - at[a];
        }
    }
    /// Returns a coordinate at the place whose corners have these weights.
    vfloat at_share(int axis, const vfloat (&share)[3]) const noexcept
    {
        return fma(edge[0][axis], share[1], fma(edge[1][axis], share[2], at[axis]));
    }
    /// Returns the width, in units of the coordinates, of a beam of this width on the triangle.
    vfloat width_on(const Triangles& tri, vfloat width) const noexcept
    {
        const vfloat zero = 0.0f;
        const vfloat area = abs(difference_of_products(edge[0][0], edge[1][1], edge[0][1], edge[1][0]));
        return select((tri.area > zero) & (area > zero), width * sqrt(area / tri.area), zero);
    }
    void set_where(vmask here, const UvLanes& from) noexcept
    {
        for (int a = 0; a < 2; ++a) {
            at[a] = select(here, from.at[a], at[a]);
            for (int p = 0; p < 2; ++p) edge[p][a] = select(here, from.edge[p][a], edge[p][a]);
        }
    }
};

struct Tangents {
    VecLanes along;  ///< unit length, or 0
    vfloat sign;
    vfloat v_axis[2];  ///< SurfaceHit::v_axis
};

/// The vectors dP/du and dP/dv are the columns of the inverse of (du/dP, dv/dP): each lies in the plane, at a right
/// angle to the other coordinate's gradient. Only the ratio of their lengths matters here, and the sign of the gradients'
/// area.
inline Tangents tangents(const Triangles& tri, const UvLanes& uv, const VecLanes& outward) noexcept
{
    VecLanes d[2];
    vfloat size[2];
    for (int a = 0; a < 2; ++a) {
        size[a] = max(abs(uv.edge[0][a]), abs(uv.edge[1][a]));
        const vfloat scale = select(size[a] > vfloat(0.0f), vfloat(1.0f) / size[a], 0.0f);
        d[a] = tri.way[0] * (uv.edge[0][a] * scale) + tri.way[1] * (uv.edge[1][a] * scale);
    }
    const vfloat zero = 0.0f, turn = dot(tri.normal, cross(d[0], d[1])), hand = select(turn > zero, 1.0f, -1.0f);
    const VecLanes along_u = cross(d[1], tri.normal) * hand, along_v = cross(tri.normal, d[0]) * hand;
    const VecLanes tangent = along_u - outward * dot(along_u, outward);
    const vfloat length = sqrt(dot(tangent, tangent));
    const vmask known = ((turn > zero) | (turn < zero)) & (length > zero) & (length <= vfloat(FLT_MAX));
    const VecLanes along = select(known, tangent * (vfloat(1.0f) / length), VecLanes{0.0f, 0.0f, 0.0f});
    const vfloat ratio = select(known, size[0] / (size[1] * length), zero);
    return {along,
            select(known & (dot(cross(outward, tangent), along_v) > zero), -1.0f, 1.0f),
            {dot(along_v, along) * ratio, dot(along_v, cross(outward, along)) * ratio}};
}

/// Says by which sets of coordinates the maps of directions at hits are turned.
struct MapSetLanes {
    vfloat of;       ///< axes_set_of() of each lane's material; negative without such a map, or if nothing can be turned
    bool any;        ///< whether some material has such a map
    bool any_other;  ///< whether some has one that is turned by the other set
};

/// Holds the texture coordinates at hits, in lanes.
struct UvAtHits {
    vfloat at[2][2], width[2];  ///< set, axis; the width of the beam in units of uv
    Tangents tangent;           ///< for the material's normal map; 0 without one or without coordinates
    Tangents other_tangent;     ///< of the other set of coordinates, if a map has its axes from there; else 0

    /// width_of_beam   where it hits
    /// outward         the shading normal, outside
    UvAtHits(const HitCorners& corners, const Triangles& tri, const vfloat (&share)[3], vfloat width_of_beam,
             const MapSetLanes& maps, const VecLanes& outward) noexcept
        : tangent{VecLanes{0.0f, 0.0f, 0.0f}, 1.0f, {0.0f, -1.0f}}, other_tangent(tangent)
    {
        const vfloat zero = 0.0f;
        UvLanes of_map, of_other;  // lanes without a map or coordinates are all 0, and so is the tangent
        for (int s = 0; s < 2; ++s) {
            at[s][0] = at[s][1] = width[s] = zero;
            if (corners.has_uv[s] == 0) continue;
            const UvLanes uv(corners.uv[s]);
            for (int a = 0; a < 2; ++a) at[s][a] = uv.at_share(a, share);
            width[s] = uv.width_on(tri, width_of_beam);
            if (maps.any) of_map.set_where(maps.of == vfloat(float(s)), uv);
            if (maps.any_other) of_other.set_where(maps.of == vfloat(float(1 - s)), uv);
        }
        if (maps.any) tangent = tangents(tri, of_map, outward);
        if (maps.any_other) other_tangent = tangents(tri, of_other, outward);
    }
};

}  // namespace occam::accel
