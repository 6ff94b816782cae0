#include "scenegraph/frame_scale.h"

#include <algorithm>
#include <cmath>

namespace occam {

FrameScale::FrameScale(const Box3d& world_bounds) noexcept
{
    constexpr int kLargest = 1000;  // powers of two beyond it are not exact in double
    if (world_bounds.is_empty()) return;
    const Vec3d extent = world_bounds.extent();
    const double largest = std::max({extent.x, extent.y, extent.z});
    if (largest > 0 && std::isfinite(largest)) exponent_ = std::clamp(std::ilogb(largest), -kLargest, kLargest);
}

Mat4d FrameScale::placed(const Mat4d& world_from_node) const noexcept
{
    Mat4d m = world_from_node;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) m[column][row] *= to_frame();
    return m;
}

Camera FrameScale::placed(const Camera& camera) const noexcept
{
    Camera out = camera;
    const auto place = [&](Mat4d& world_from_camera) {
        for (int row = 0; row < 3; ++row) world_from_camera[3][row] *= to_frame();
    };
    place(out.world_from_camera);
    for (Mat4d& key : out.keys) place(key);
    for (float* length : {&out.lens.height, &out.lens.radius, &out.lens.focus}) *length = to_frame(*length);
    return out;
}

}  // namespace occam
