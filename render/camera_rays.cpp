#include "render/camera_rays.h"

#include <algorithm>

#include "render/aperture.h"

namespace occam::render {

CameraRays::CameraRays(const Camera& camera, int width, int height, int samples) noexcept
    : eye_(camera.eye()), width_(width), height_(height), orthographic_(camera.lens.orthographic), samples_(samples)
{
    if (camera.lens.radius > 0 && camera.lens.focus > 0) {
        lens_radius_ = camera.lens.radius;
        focus_ = camera.lens.focus;
        blades_ = camera.lens.blades;
    }
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
    // A point is in view if |across| <= forward * (width / height) and |up| <= forward, where across and up are in units of
    // half the height.
    const auto inverse = [](Vec3d v) { return v / glm::dot(v, v); };
    const Vec3d sides = forward_ * (width_ / height_);
    levels.plane_count = 4;
    levels.planes[0] = Vec4d(sides + inverse(right_), 0);
    levels.planes[1] = Vec4d(sides - inverse(right_), 0);
    levels.planes[2] = Vec4d(forward_ + inverse(up_), 0);
    levels.planes[3] = Vec4d(forward_ - inverse(up_), 0);
    return levels;
}

void CameraRays::take_footprints_of(const CameraRays& other) noexcept
{
    footprints_are_own_ = false;
    footprint_ = {other.pixel_.at(static_cast<float>(glm::distance(eye_, other.eye_))), other.pixel_.b};
}

accel::Ray CameraRays::ray(double x, double y, Vec2f lens) const noexcept
{
    const Vec3d across = right_ * ((2 * x - width_) / height_) + up_ * (1 - 2 * y / height_);
    accel::Ray ray;
    ray.kinds = accel::RayKind::Camera;
    ray.footprint = pixel_;
    ray.origin = orthographic_ ? eye_ + across : eye_;
    Vec3d d = orthographic_ ? forward_ : forward_ + across;  // leads to the point where camera z is 1
    if (has_lens()) {
        // All rays through one place in the image meet at the plane of focus.
        const Vec2d at(aperture_point(lens, blades_) * lens_radius_);
        const Vec3d shift = glm::normalize(right_) * at.x + glm::normalize(up_) * at.y;
        ray.origin += shift;
        d -= shift / double(focus_);
    }
    const double length = glm::length(d);
    ray.direction = Vec3f(d / length);
    ray.footprint.b = static_cast<float>(double(pixel_.b) / length);
    if (has_lens()) {
        ray.t_far = static_cast<float>(double(focus_) * length);
        ray.footprint = lens_beams_of(ray).near_side;
    }
    if (!footprints_are_own_) ray.footprint = footprint_;
    return ray;
}

shade::LensBeams CameraRays::lens_beams_of(const accel::Ray& ray) const noexcept
{
    const lod::Footprint pixel = orthographic_ ? lod::Footprint{pixel_.a, 0}
                                               : lod::Footprint{0, pixel_.b * focus_ / ray.t_far};
    return shade::lens_beams(pixel, 2 * lens_radius_, ray.t_far, samples_);
}

accel::Ray CameraRays::behind_focus(accel::Ray ray) const noexcept
{
    if (footprints_are_own_) ray.footprint = lens_beams_of(ray).far_side;
    // Both pieces reach slightly beyond the focus, so that rounding loses nothing there.
    ray.t_near = std::max(ray.t_near, ray.t_far * (1 - 4 * std::numeric_limits<float>::epsilon()));
    ray.t_far = std::numeric_limits<float>::infinity();
    return ray;
}

}  // namespace occam::render
