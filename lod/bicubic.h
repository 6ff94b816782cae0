// Uniform cubic B-splines: their weights, and the points of one patch from its 4 x 4 control points.
//
// Space    the parameter of a piece is in [0, 1]; derivatives are with respect to it.
// Bits     Points are a pure function of the parameter and the control points, so every grid, level and tile that asks for a
//          point gets the same bits. The order is fixed: first along v, then along u, coefficients in ascending order.
//          Points of a curve along v, which borders are made of, go first along u (column_controls()), and may differ in
//          their last bit from points that grids ask for, so that a border has points of its curve alone.
#pragma once

#include "base/simd.h"
#include "base/vec.h"

namespace occam::lod {

struct CubicWeights {
    float b[4];
};

/// Returns the four basis functions at t.
inline CubicWeights cubic_weights(double t) noexcept
{
    const double s = 1 - t;
    return {{float(s * s * s / 6), float((4 + t * t * (3 * t - 6)) / 6), float((4 + s * s * (3 * s - 6)) / 6),
             float(t * t * t / 6)}};
}

/// Returns the derivatives of the basis functions at t.
inline CubicWeights cubic_derivative_weights(double t) noexcept
{
    const double s = 1 - t;
    return {{float(-s * s / 2), float(t * (1.5 * t - 2)), float(-s * (1.5 * s - 2)), float(t * t / 2)}};
}

/// The four Bezier points of a B-spline curve between a and b, as weights of its control points: not negative, sum 1.
struct BezierWeights {
    CubicWeights row[4];
};

/// Computes these weights by the polar form (Ramshaw 1989): f(a,a,a), f(a,a,b), f(a,b,b), f(b,b,b) over the knots -2 .. 3.
inline BezierWeights bezier_weights(double a, double b) noexcept
{
    const auto polar = [](double r, double s, double t) -> CubicWeights {
        // The weight of a control point is 1 at its own three consecutive knots, and multi-affine and symmetric in r, s, t.
        const double w0 = (1 - r) * (1 - s) * (1 - t) / 6, w3 = r * s * t / 6;
        const double sum = r + s + t, pairs = r * s + s * t + t * r, all = r * s * t;
        return {{float(w0), float((4 - 2 * pairs + 3 * all) / 6), float((1 + sum + pairs - 3 * all) / 6), float(w3)}};
    };
    return {{polar(a, a, a), polar(a, a, b), polar(a, b, b), polar(b, b, b)}};
}

/// The control points of one bicubic piece, component-major; point (i, j) of the 4 x 4 net is at j * 4 + i, with i along u.
struct alignas(32) PieceControls {
    float c[3][16];
};

/// Returns sum_k w[k] q[k * stride], added in ascending order.
inline float cubic_sum(const CubicWeights& w, const float* q, int stride) noexcept
{
    return fma(w.b[3], q[3 * stride], fma(w.b[2], q[2 * stride], fma(w.b[1], q[stride], w.b[0] * q[0])));
}

/// The net's four columns at one v: a cubic curve along u, component-major.
struct alignas(16) CurveControls {
    float c[3][4];
};

inline CurveControls row_controls(const PieceControls& p, const CubicWeights& v) noexcept
{
    CurveControls row;
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < 4; ++i) row.c[a][i] = cubic_sum(v, &p.c[a][i], 4);
    return row;
}
/// The net's four rows at one u: a cubic curve along v.
inline CurveControls column_controls(const PieceControls& p, const CubicWeights& u) noexcept
{
    CurveControls column;
    for (int a = 0; a < 3; ++a)
        for (int j = 0; j < 4; ++j) column.c[a][j] = cubic_sum(u, &p.c[a][j * 4], 1);
    return column;
}
inline Vec3f curve_point(const CurveControls& q, const CubicWeights& w) noexcept
{
    return {cubic_sum(w, q.c[0], 1), cubic_sum(w, q.c[1], 1), cubic_sum(w, q.c[2], 1)};
}

}  // namespace occam::lod
