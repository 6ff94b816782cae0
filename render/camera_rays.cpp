#include "render/camera_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lod/rates.h"
#include "render/aperture.h"

namespace occam::render {

CameraRays::CameraRays(const Camera& camera, int width, int height, int samples, float shading_rate)
    : width_(width), height_(height), orthographic_(camera.lens.orthographic), samples_(samples)
{
    if (camera.lens.radius > 0 && camera.lens.focus > 0) {
        lens_radius_ = camera.lens.radius;
        focus_ = camera.lens.focus;
        blades_ = camera.lens.blades;
    }
    const double half = orthographic_ ? double(camera.lens.height) * 0.5 : double(maths::tan(camera.lens.fov * 0.5f));
    half_ = half;
    middle_ = view_of(camera.world_from_camera, half);
    if (camera.keys.size() > 1)
        for (const Mat4d& key : camera.keys) keys_.push_back(view_of(key, 1));
    const float pixel = static_cast<float>(2 * half / height_);
    pixel_ = orthographic_ ? lod::Footprint{pixel, 0} : lod::Footprint{0, pixel};
    if (!has_lens()) return;
    const int level = std::ilogb(levels(shading_rate).target_edge(pixel_).at(focus_));
    level_at_focus_ = static_cast<std::int8_t>(std::clamp(level, lod::kFinestLevel, lod::kCoarsestLevel));
}

CameraRays::View CameraRays::view_of(const Mat4d& world_from_camera, double half) const noexcept
{
    return {Vec3d(world_from_camera[3]), -glm::normalize(Vec3d(world_from_camera[2])),
            glm::normalize(Vec3d(world_from_camera[0])) * half, glm::normalize(Vec3d(world_from_camera[1])) * half};
}

// Elements are interpolated, and the axes brought back to unit length: then a camera that turns keeps its field of view.
CameraRays::View CameraRays::view_at(double time) const noexcept
{
    if (keys_.empty()) return middle_;
    const double along = std::clamp(time, 0.0, 1.0) * static_cast<double>(keys_.size() - 1);
    const std::size_t first = std::min(static_cast<std::size_t>(along), keys_.size() - 2);
    const View &a = keys_[first], &b = keys_[first + 1];
    const double s = along - static_cast<double>(first);
    const auto mix = [&](Vec3d from, Vec3d to) { return from + (to - from) * s; };
    // Opposite axes meet in the middle at 0. A camera that turns by half a turn in one step is cut there.
    const auto unit = [&](Vec3d from, Vec3d to) {
        const Vec3d v = mix(from, to);
        const double length = glm::length(v);
        return length > 1e-6 ? v / length : to;
    };
    return {mix(a.eye, b.eye), unit(a.forward, b.forward), unit(a.right, b.right) * half_, unit(a.up, b.up) * half_};
}

double CameraRays::depth(Vec3d point, float time) const noexcept
{
    const View view = view_at(double(time));
    return glm::dot(point - view.eye, view.forward);
}

Vec2d CameraRays::place_in_image(const View& view, Vec3d point) const noexcept
{
    // Between two keys the axes are not quite perpendicular.
    const Vec3d at = glm::inverse(Mat3d(view.right, view.up, view.forward)) * (point - view.eye);
    const double scale = orthographic_ ? height_ / 2 : height_ / (2 * at.z);
    return {width_ / 2 + at.x * scale, height_ / 2 - at.y * scale};
}

// A difference over a short time on both sides: at a key of the camera it is the mean of the speeds before and after.
Vec2d CameraRays::pixel_velocity(Vec3d point, Vec3d velocity, float time) const noexcept
{
    constexpr double kStep = 1e-4;
    const double before = std::max(double(time) - kStep, 0.0), after = std::min(double(time) + kStep, 1.0);
    const View from = view_at(before), to = view_at(after);
    const Vec3d start = point + velocity * (before - double(time)), end = point + velocity * (after - double(time));
    const auto is_in_front = [&](const View& view, Vec3d p) {
        return orthographic_ || glm::dot(p - view.eye, view.forward) > 0;
    };
    if (!is_in_front(from, start) || !is_in_front(to, end)) return Vec2d(0);
    const Vec2d pixels = (place_in_image(to, end) - place_in_image(from, start)) / (after - before);
    return std::isfinite(pixels.x) && std::isfinite(pixels.y) ? pixels : Vec2d(0);
}

lod::LevelSettings CameraRays::levels(float shading_rate) const
{
    lod::LevelSettings levels{middle_.eye, pixel_, shading_rate, 0, {}};
    for (const View& key : keys_) {
        levels.eyes.push_back(key.eye);
        levels.eye_moves = std::max(levels.eye_moves, glm::distance(key.eye, middle_.eye));
    }
    // What a moving camera sees lies in no single pyramid.
    if (orthographic_ || moves()) return levels;
    // A point is in view if |across| <= forward * (width / height) and |up| <= forward, where across and up are in units of
    // half the height.
    const auto inverse = [](Vec3d v) { return v / glm::dot(v, v); };
    const auto& [eye, forward, right, up] = middle_;
    const Vec3d sides = forward * (width_ / height_);
    levels.plane_count = 4;
    levels.planes[0] = Vec4d(sides + inverse(right), 0);
    levels.planes[1] = Vec4d(sides - inverse(right), 0);
    levels.planes[2] = Vec4d(forward + inverse(up), 0);
    levels.planes[3] = Vec4d(forward - inverse(up), 0);
    return levels;
}

void CameraRays::take_footprints_of(const CameraRays& other) noexcept
{
    footprints_are_own_ = false;
    double apart = glm::distance(eye(), other.eye());
    for (const View& key : keys_) apart = std::max(apart, glm::distance(key.eye, other.eye()));
    footprint_ = {other.pixel_.at(static_cast<float>(apart)), other.pixel_.b};
}

accel::Ray CameraRays::ray(double x, double y, Vec2f lens, float time) const noexcept
{
    View moved;
    if (moves()) moved = view_at(double(time));
    const View& view = moves() ? moved : middle_;
    const Vec3d across = view.right * ((2 * x - width_) / height_) + view.up * (1 - 2 * y / height_);
    accel::Ray ray;
    ray.time = time;
    ray.kinds = accel::RayKind::Camera;
    ray.footprint = pixel_;
    ray.origin = orthographic_ ? view.eye + across : view.eye;
    Vec3d d = orthographic_ ? view.forward : view.forward + across;  // leads to the point where camera z is 1
    if (has_lens()) {
        // All rays through one place in the image meet at the plane of focus.
        const Vec2d at(aperture_point(lens, blades_) * lens_radius_);
        const Vec3d shift = glm::normalize(view.right) * at.x + glm::normalize(view.up) * at.y;
        ray.origin += shift;
        d -= shift / double(focus_);
    }
    const double length = glm::length(d);
    ray.direction = Vec3f(d / length);
    ray.footprint.b = static_cast<float>(double(pixel_.b) / length);
    if (ends_at_focus()) {
        ray.t_far = ray.focus = static_cast<float>(double(focus_) * length);
        ray.start_level = level_at_focus_;
        ray.footprint = lens_beams_of(ray).near_side;
    }
    if (!footprints_are_own_) ray.footprint = footprint_;
    return ray;
}

shade::LensBeams CameraRays::lens_beams_of(const accel::Ray& ray) const noexcept
{
    const lod::Footprint pixel = orthographic_ ? lod::Footprint{pixel_.a, 0}
                                               : lod::Footprint{0, pixel_.b * focus_ / ray.focus};
    return shade::lens_beams(pixel, 2 * lens_radius_, ray.focus, samples_);
}

accel::Ray CameraRays::behind_focus(accel::Ray ray) const noexcept
{
    ray.footprint = lens_beams_of(ray).far_side;
    // Both pieces have the same bits of all hits around the focus. So it is enough that no distance lies in neither of them.
    ray.t_near = std::max(ray.t_near, ray.focus * (1 - 4 * std::numeric_limits<float>::epsilon()));
    ray.t_far = std::numeric_limits<float>::infinity();
    return ray;
}

}  // namespace occam::render
