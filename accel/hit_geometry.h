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
};

/// The vectors dP/du and dP/dv are the columns of the inverse of (du/dP, dv/dP): each lies in the plane, at a right
/// angle to the other coordinate's gradient. Their lengths do not matter here, but the sign of the gradients' area
/// does.
inline Tangents tangents(const Triangles& tri, const UvLanes& uv, const VecLanes& outward) noexcept
{
    VecLanes d[2];
    for (int a = 0; a < 2; ++a) {
        const vfloat size = max(abs(uv.edge[0][a]), abs(uv.edge[1][a]));
        const vfloat scale = select(size > vfloat(0.0f), vfloat(1.0f) / size, 0.0f);
        d[a] = tri.way[0] * (uv.edge[0][a] * scale) + tri.way[1] * (uv.edge[1][a] * scale);
    }
    const vfloat zero = 0.0f, turn = dot(tri.normal, cross(d[0], d[1])), hand = select(turn > zero, 1.0f, -1.0f);
    const VecLanes along_u = cross(d[1], tri.normal) * hand, along_v = cross(tri.normal, d[0]) * hand;
    const VecLanes tangent = along_u - outward * dot(along_u, outward);
    const vfloat length = sqrt(dot(tangent, tangent));
    const vmask known = ((turn > zero) | (turn < zero)) & (length > zero) & (length <= vfloat(FLT_MAX));
    return {select(known, tangent * (vfloat(1.0f) / length), VecLanes{0.0f, 0.0f, 0.0f}),
            select(known & (dot(cross(outward, tangent), along_v) > zero), -1.0f, 1.0f)};
}

}  // namespace occam::accel
