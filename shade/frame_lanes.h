// Frames and maps onto discs for several surfaces side by side: what shade/frame_of.h does for one, with the same bits.
#pragma once

#include "shade/frame_of.h"
#include "shade/lane_vectors.h"

namespace occam::shade {

/// The same as ShadingFrame.
struct FrameLanes {
    VecLanes x, y, z;

    explicit FrameLanes(const VecLanes& unit) noexcept : z(unit)
    {
        const vfloat sign = copysign(vfloat(1.0f), unit.z);
        const vfloat a = -1.0f / (sign + unit.z), b = unit.x * unit.y * a;
        x = {1 + sign * unit.x * unit.x * a, sign * b, -sign * unit.x};
        y = {b, sign + unit.y * unit.y * a, -unit.y};
    }
    VecLanes to_world(const VecLanes& v) const noexcept { return x * v.x + y * v.y + z * v.z; }
    VecLanes to_local(const VecLanes& v) const noexcept { return {dot(v, x), dot(v, y), dot(v, z)}; }
};

/// Holds what disc_point() returns.
struct DiscPoints {
    vfloat x, y;

    DiscPoints(vfloat u, vfloat v) noexcept
    {
        const vfloat px = u * 2.0f - 1.0f, py = v * 2.0f - 1.0f, zero = 0.0f;
        const vmask wide = abs(px) > abs(py);
        const vfloat ratio = kPi / 4 * (select(wide, py, px) / select(wide, px, py));
        const vmask is_middle = (px == zero) & (py == zero);
        LaneFloats angle, sin, cos;
        angle = select(is_middle, zero, select(wide, ratio, kPi / 2 - ratio));
        maths::sin_cos(angle.of, kLanes, sin.of, cos.of);
        const vfloat radius = select(wide, px, py);
        x = select(is_middle, zero, radius * cos.lanes());
        y = select(is_middle, zero, radius * sin.lanes());
    }
};

}  // namespace occam::shade
