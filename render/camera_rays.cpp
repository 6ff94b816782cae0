#include "render/camera_rays.h"

#include <algorithm>

#include "scenegraph/base/maths.h"

namespace occam::render {

CameraRays::CameraRays(const Camera& camera, int width, int height) noexcept
    : eye_(camera.eye()), width_(width), height_(height), orthographic_(camera.lens.orthographic)
{
    const float half_fov = std::clamp(camera.lens.fov, 1e-4f, 3.14f) * 0.5f;
    const double half = orthographic_ ? double(camera.lens.height) * 0.5 : double(maths::tan(half_fov));
    forward_ = -glm::normalize(Vec3d(camera.world_from_camera[2]));
    right_ = glm::normalize(Vec3d(camera.world_from_camera[0])) * half;
    up_ = glm::normalize(Vec3d(camera.world_from_camera[1])) * half;
    const float pixel = static_cast<float>(2 * half / height_);
    pixel_ = orthographic_ ? lod::Footprint{pixel, 0} : lod::Footprint{0, pixel};
}

lod::LevelSettings CameraRays::levels(float shading_rate) const noexcept
{
    lod::LevelSettings levels{eye_, pixel_, shading_rate, 0, {}};
    if (orthographic_) return levels;
    // A point in view has |across| <= forward * (width / height), |up| <= forward, across and up in units of half the height.
    const auto inverse = [](Vec3d v) { return v / glm::dot(v, v); };
    const Vec3d sides = forward_ * (width_ / height_);
    levels.plane_count = 4;
    levels.planes[0] = Vec4d(sides + inverse(right_), 0);
    levels.planes[1] = Vec4d(sides - inverse(right_), 0);
    levels.planes[2] = Vec4d(forward_ + inverse(up_), 0);
    levels.planes[3] = Vec4d(forward_ - inverse(up_), 0);
    return levels;
}

accel::Ray CameraRays::ray(double x, double y) const noexcept
{
    const Vec3d across = right_ * ((2 * x - width_) / height_) + up_ * (1 - 2 * y / height_);
    accel::Ray ray;
    ray.footprint = pixel_;
    if (orthographic_) {
        ray.origin = eye_ + across;
        ray.direction = Vec3f(forward_);
        return ray;
    }
    const Vec3d d = forward_ + across;
    const double length = glm::length(d);
    ray.origin = eye_;
    ray.direction = Vec3f(d / length);
    ray.footprint.b = static_cast<float>(double(pixel_.b) / length);  // a pixel lies `length` away where z is 1
    return ray;
}

}  // namespace occam::render
