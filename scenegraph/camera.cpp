#include "scenegraph/camera.h"

#include <algorithm>
#include <cmath>

#include "base/error_without_file.h"
#include "base/maths.h"
#include "base/unit_vector.h"
#include "scenegraph/content_rules.h"

namespace occam {

namespace {

constexpr double kLeastSine = 1e-9;  // of the angle between the view and up: below it, they are taken for parallel

}  // namespace

bool is_along(Vec3d view, Vec3d up) noexcept
{
    return glm::length(glm::cross(unit_vector(up), unit_vector(view))) <= kLeastSine;
}

Camera Camera::look_at(Vec3d eye, Vec3d target, Vec3d up, float fov)
{
    const Vec3d back = unit_vector(eye - target), upwards = unit_vector(up);
    if (back == Vec3d(0)) throw error_without_file("the eye and the target must be finite and apart", "look_at");
    if (upwards == Vec3d(0)) throw error_without_file("the direction up must be finite and not zero", "look_at");
    check_view_angle(fov, "look_at");
    Vec3d right = glm::cross(upwards, back);
    // If the camera looks along `up`, any direction to the right will do, as long as it is always the same.
    if (is_along(back, up)) right = glm::cross(std::abs(back.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0), back);
    right = right / glm::length(right);
    Camera camera;
    camera.world_from_camera = {Vec4d(right, 0), Vec4d(glm::cross(back, right), 0), Vec4d(back, 0), Vec4d(eye, 1)};
    camera.lens.fov = fov;
    return camera;
}

Camera Camera::framing(const Box3d& bounds, float aspect)
{
    check_aspect(aspect, "framing");
    constexpr double kMargin = 1.1;
    const Vec3d direction = Vec3d(0.4, 0.35, 1.0) / glm::length(Vec3d(0.4, 0.35, 1.0));  // from the scene to the eye
    const Vec3d centre = bounds.is_empty() ? Vec3d(0) : bounds.centre();
    const Vec3d half = bounds.is_empty() ? Vec3d(1) : bounds.extent() * 0.5;
    const auto is_finite = [](const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    if (!is_finite(centre) || !is_finite(half)) throw error_without_file("the bounds must be finite", "framing");
    Camera camera = look_at(direction, Vec3d(0), {0, 1, 0}, CameraLens().fov);  // the same axes wherever the scene is

    // A corner c (relative to the centre, in camera axes) is visible if |c.x| <= (d - c.z) k aspect and |c.y| <= (d - c.z)
    // k.
    const double k = double(maths::tan(camera.lens.fov * 0.5f));
    const double k_x = k * double(aspect);
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d c = half * Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const Vec3d in_camera(glm::dot(c, Vec3d(camera.world_from_camera[0])),
                              glm::dot(c, Vec3d(camera.world_from_camera[1])),
                              glm::dot(c, Vec3d(camera.world_from_camera[2])));
        distance = std::max({distance, in_camera.z + kMargin * std::abs(in_camera.x) / k_x,
                             in_camera.z + kMargin * std::abs(in_camera.y) / k});
    }
    if (!(distance > 0)) distance = 1;
    camera.world_from_camera[3] = Vec4d(centre + direction * distance, 1);
    return camera;
}

}  // namespace occam
