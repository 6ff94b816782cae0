// Axis-aligned boxes. They are closed, and empty until something is added.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/vec.h"

namespace occam {

template <class Vec>
struct Box {
    using Real = typename Vec::value_type;

    Vec lo{std::numeric_limits<Real>::infinity()};
    Vec hi{-std::numeric_limits<Real>::infinity()};

    void add(Vec p) noexcept
    {
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
    }
    void add(const Box& b) noexcept
    {
        lo = glm::min(lo, b.lo);
        hi = glm::max(hi, b.hi);
    }
    bool is_empty() const noexcept { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
    Vec centre() const noexcept { return (lo + hi) * Real(0.5); }
    Vec extent() const noexcept { return hi - lo; }
    /// Returns half the diagonal: the radius of the bounding sphere.
    Real radius() const noexcept { return is_empty() ? Real(0) : glm::length(extent()) * Real(0.5); }
    /// Returns half of the surface area (the surface area heuristic needs only ratios).
    Real half_area() const noexcept
    {
        const Vec e = extent();
        return e.x * e.y + e.y * e.z + e.z * e.x;
    }
    Real largest_coordinate() const noexcept
    {
        const Vec m = glm::max(glm::abs(lo), glm::abs(hi));
        return std::max(m.x, std::max(m.y, m.z));
    }
};

using Box3f = Box<Vec3f>;
using Box3d = Box<Vec3d>;

/// Returns the bounds of a box's image under an affine map.
inline Box3d transform_box(const Mat4d& m, const Box3d& b) noexcept
{
    if (b.is_empty()) return b;
    const Vec3d c = transform_point(m, b.centre());
    const Vec3d e = b.extent() * 0.5;
    const Vec3d r = glm::abs(Vec3d(m[0])) * e.x + glm::abs(Vec3d(m[1])) * e.y + glm::abs(Vec3d(m[2])) * e.z;
    return {c - r, c + r};
}

/// Moves the origin to `anchor` and rounds outward to float; the result grows by `ulps` of the largest coordinate.
inline Box3f outward_float(const Box3d& b, Vec3d anchor, float ulps) noexcept
{
    if (b.is_empty()) return {};
    Box3f f{Vec3f(b.lo - anchor), Vec3f(b.hi - anchor)};
    const float pad = f.largest_coordinate() * ulps * std::numeric_limits<float>::epsilon();
    return {f.lo - Vec3f(pad), f.hi + Vec3f(pad)};
}

}  // namespace occam
