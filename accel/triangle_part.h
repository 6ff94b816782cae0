// The part of a triangle that lies in a box, by the shares that the triangle's corners have in the corners of that part. So
// it is the same part of the triangle, wherever the triangle moves (Grünschloß et al. 2011, sec. 3).
#pragma once

#include "base/box.h"

namespace occam::accel {

class TrianglePart {
public:
    /// Begins with the whole triangle.
    explicit TrianglePart(const Vec3f* corners) noexcept;

    /// Cuts off what is below a plane across an axis, or what is above it.
    void cut_below(int axis, double plane) noexcept { cut(axis, plane, 1); }
    void cut_above(int axis, double plane) noexcept { cut(axis, plane, -1); }
    /// Cuts off what is outside of a box.
    void cut_to(const Box3f& box) noexcept;

    bool is_empty() const noexcept { return count_ == 0; }
    /// Returns the part's box, rounded outward.
    Box3f box() const noexcept;
    /// Returns the box of the same part where the triangle's corners are elsewhere.
    Box3f box_at(const Vec3f* corners) const noexcept;

private:
    // Six planes add one corner each or, where rounding has made the part slightly concave, two.
    static constexpr int kMost = 3 + 6 * 2;
    struct Corner {
        Vec3d at, share;
    };
    /// Keeps what lies on the side of the plane to which `sign` points.
    void cut(int axis, double plane, double sign) noexcept;

    Vec3d triangle_[3];
    Corner corners_[kMost];
    int count_ = 3;
};

}  // namespace occam::accel
