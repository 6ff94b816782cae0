#include "scenegraph/camera_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error_without_file.h"
#include "base/maths.h"
#include "base/unit_vector.h"
#include "scenegraph/content_rules.h"

namespace occam {
namespace {

// Returns the direction from the scene to the eye, in components along right, up and front.
Vec3d direction_of(ViewFrom side)
{
    switch (side) {
        case ViewFrom::ThreeQuarter:
            return {0.4, 0.35, 1.0};
        case ViewFrom::Front:
            return {0, 0, 1};
        case ViewFrom::Side:
            return {1, 0, 0};
        case ViewFrom::Back:
            return {0, 0, -1};
        case ViewFrom::Top:
            return {0, 1, 0};
        case ViewFrom::Bottom:
            return {0, -1, 0};
    }
    throw error_without_file("there is no such side", "ViewFrom");
}

}  // namespace

CameraFit::CameraFit(ViewFrom side, Vec3d up, float fov, float aspect) : fov_(fov)
{
    constexpr double kMargin = 1.06;
    check_view_angle(fov, "framing");
    check_aspect(aspect, "framing");
    up = unit_vector(up);
    if (up == Vec3d(0)) throw error_without_file("a direction must be finite and not zero", "up");
    Vec3d front = std::abs(up.z) > 0.7 ? Vec3d(0, -1, 0) : Vec3d(0, 0, 1);
    front -= up * glm::dot(front, up);
    front = front / glm::length(front);
    const Vec3d right = glm::cross(up, front), d = direction_of(side);
    back_ = right * d.x + up * d.y + front * d.z;
    back_ = back_ / glm::length(back_);
    // A picture from the top has the front at its lower border, and one from the bottom at its upper border.
    const Vec3d upwards = side == ViewFrom::Top ? -front : side == ViewFrom::Bottom ? front : up;
    right_ = glm::cross(upwards, back_);
    right_ = right_ / glm::length(right_);
    up_ = glm::cross(back_, right_);
    slope_y_ = double(maths::tan(fov * 0.5f)) / kMargin;
    slope_x_ = slope_y_ * double(aspect);
    clear();
}

void CameraFit::clear() noexcept
{
    box_ = Box3d();
    right_most_ = left_most_ = highest_ = lowest_ = -std::numeric_limits<double>::infinity();
}

void CameraFit::add(Vec3d point) noexcept
{
    const Vec3d c(glm::dot(point, right_), glm::dot(point, up_), glm::dot(point, back_));
    if (!std::isfinite(c.x + c.y + c.z)) return;
    box_.add(c);
    right_most_ = std::max(right_most_, slope_x_ * c.z + c.x);
    left_most_ = std::max(left_most_, slope_x_ * c.z - c.x);
    highest_ = std::max(highest_, slope_y_ * c.z + c.y);
    lowest_ = std::max(lowest_, slope_y_ * c.z - c.y);
}

Camera CameraFit::camera() const
{
    if (is_empty()) {
        CameraFit unit = *this;
        for (int i = 0; i < 8; ++i) unit.add(Vec3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        return unit.camera();
    }
    // A point lies left of the right side of the view if c.x <= eye.x + (eye.z - c.z) slope_x, so eye.x + slope_x eye.z has
    // to be at least right_most_. The other three sides give similar bounds, and eye.x drops out of the sum of two opposite
    // ones.
    double z = std::max((right_most_ + left_most_) / (2 * slope_x_), (highest_ + lowest_) / (2 * slope_y_));
    // A needle that points at the eye fits at any distance, so the eye keeps a distance from it.
    const Vec3d extent = box_.extent();
    const double spread = std::max({extent.x, extent.y, extent.z});
    z = std::max(z, box_.hi.z + (spread > 0 ? 0.02 * spread : std::max(1.0, 1e-6 * box_.largest_coordinate())));
    Camera camera;
    camera.lens.fov = fov_;
    camera.world_from_camera = {
        Vec4d(right_, 0), Vec4d(up_, 0), Vec4d(back_, 0),
        Vec4d(right_ * ((right_most_ - left_most_) / 2) + up_ * ((highest_ - lowest_) / 2) + back_ * z, 1)};
    return camera;
}

}  // namespace occam
