#include "render/camera_rays.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenegraph/content_rules.h"

namespace occam::render {
namespace {

// The convention of the reference pictures is d = f + (2 x / w - 1) k aspect r + (1 - 2 y / h) k u.
TEST(CameraRays, FollowTheConventionOfTheReferencePictures)
{
    const Vec3d eye(1, 2, 3), target(-2, 1, 0.5);
    const float fov = 0.7f;
    const CameraRays rays(Camera::look_at(eye, target, {0, 1, 0}, fov), 320, 240);
    const Vec3d f = glm::normalize(target - eye), r = glm::normalize(glm::cross(f, Vec3d(0, 1, 0))), u = glm::cross(r, f);
    const double k = std::tan(double(fov) / 2);
    for (const Vec2d at : {Vec2d(0.5, 0.5), Vec2d(319.5, 0.5), Vec2d(160, 120), Vec2d(12.5, 200.5)}) {
        const Vec3d d = f + r * ((2 * at.x / 320 - 1) * k * 4 / 3) + u * ((1 - 2 * at.y / 240) * k);
        const accel::Ray ray = rays.ray(at.x, at.y);
        EXPECT_EQ(ray.origin, eye);
        // The direction is rounded once to float, by half an ulp in each component, and the tangent adds as much again.
        EXPECT_LT(glm::length(Vec3d(ray.direction) - glm::normalize(d)), 2e-7);
        EXPECT_NEAR(rays.depth(eye + d * 5.0), 5, 1e-12);
    }
}

// What is far away is framed by a narrow angle to a hundredth of the picture's height, wherever the camera looks.
TEST(CameraRays, KeepTheFramingOfNarrowViews)
{
    constexpr int kSide = 64;
    for (const float fov : {0.1f, 1e-3f, 1e-4f, kNarrowestView})
        for (const Vec3d towards : {Vec3d(0, 0, -1), Vec3d(1, 2, -3), Vec3d(-1, 1, 1)}) {
            const double distance = 1 / double(fov);  // the picture shows one unit there
            const Vec3d eye = glm::normalize(towards) * -distance;
            const Camera camera = Camera::look_at(eye, {0, 0, 0}, {0, 1, 0}, fov);
            const CameraRays rays(camera, kSide, kSide);
            const Vec3d right(camera.world_from_camera[0]), up(camera.world_from_camera[1]);
            for (const Vec2d at : {Vec2d(0.5, 0.5), Vec2d(63.5, 10.5), Vec2d(32, 32), Vec2d(40.25, 63)}) {
                const accel::Ray ray = rays.ray(at.x, at.y);
                const double t = distance / glm::dot(Vec3d(ray.direction), -Vec3d(camera.world_from_camera[2]));
                const Vec3d there = ray.origin + Vec3d(ray.direction) * t;
                EXPECT_NEAR(glm::dot(there, right), at.x / kSide - 0.5, 0.01) << fov;
                EXPECT_NEAR(glm::dot(there, up), 0.5 - at.y / kSide, 0.01) << fov;
                EXPECT_NEAR(rays.depth(there), distance, 1e-9 * distance);
                EXPECT_NEAR(ray.footprint.at(static_cast<float>(t)) * kSide, 1, 0.01) << fov;
            }
        }
}

TEST(CameraRays, ABeamIsOnePixelWideWhereItsPixelLies)
{
    const float fov = 1;
    const CameraRays rays(Camera::look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, fov), 64, 32);
    const double pixel = 2 * std::tan(0.5) / 32;
    const accel::Ray corner = rays.ray(0, 0);
    const double t = -1 / double(corner.direction.z);  // the distance at which camera z is 1
    EXPECT_NEAR(double(corner.footprint.at(float(t))), pixel, 1e-6 * pixel);
    EXPECT_EQ(corner.footprint.a, 0);
    EXPECT_NEAR(double(rays.pixel().b), pixel, 1e-6 * pixel);
}

TEST(CameraRays, TakeAnotherCamerasFootprints)
{
    const CameraRays other(Camera::look_at({3, 1, 2}, {0, 0, 0}, {0, 1, 0}, 0.6f), 64, 32);
    CameraRays rays(Camera::look_at({-1, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1.2f), 64, 32);
    rays.take_footprints_of(other);
    const double apart = glm::distance(rays.eye(), other.eye());
    for (const float t : {0.0f, 1.0f, 5.0f, 100.0f}) {
        const accel::Ray ray = rays.ray(50, 3);
        const double distance = glm::distance(ray.origin + Vec3d(ray.direction) * double(t), other.eye());
        const double asked = double(other.pixel().at(float(distance))), found = double(ray.footprint.at(t));
        EXPECT_GE(found, asked * (1 - 1e-6));
        EXPECT_LE(found, asked * (1 + 2 * apart / distance) * (1 + 1e-6));
    }
}

TEST(CameraRays, OrthographicRaysAreParallelAndOfConstantWidth)
{
    Camera camera = Camera::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    camera.lens.orthographic = true;
    camera.lens.height = 4;
    const CameraRays rays(camera, 200, 100);
    const accel::Ray a = rays.ray(0, 0), b = rays.ray(200, 100);
    EXPECT_EQ(a.direction, b.direction);
    EXPECT_LT(glm::length(a.origin - Vec3d(-4, 2, 5)), 1e-12);
    EXPECT_LT(glm::length(b.origin - Vec3d(4, -2, 5)), 1e-12);
    EXPECT_FLOAT_EQ(a.footprint.at(100), 0.04f);
}

// Both pieces of a ray through a lens have one level at the focus, whatever their footprints are rounded to there.
TEST(CameraRays, HaveOneLevelAtTheFocusOfALens)
{
    for (const bool parallel : {false, true})
        for (const float rate : {0.25f, 1.0f, 3.0f, 16.0f}) {
            Camera camera = Camera::look_at({1, 2, 5}, {0, 0, 0}, {0, 1, 0}, 0.8f);
            camera.lens.orthographic = parallel;
            camera.lens.radius = 0.2f;
            camera.lens.focus = 3;
            const CameraRays rays(camera, 64, 48, 4, rate);
            ASSERT_TRUE(rays.ends_at_focus());
            const float edge = lod::LevelSettings::kLongestEdge * rate * rays.pixel().at(3);
            for (const Vec2f lens : {Vec2f(0.1f, 0.2f), Vec2f(0.9f, 0.6f)}) {
                const accel::Ray ray = rays.ray(3, 40, lens), rest = rays.behind_focus(ray);
                EXPECT_EQ(ray.start_level, std::ilogb(edge));
                EXPECT_EQ(ray.focus, ray.t_far);
                EXPECT_EQ(rest.start_level, ray.start_level);
                EXPECT_EQ(rest.focus, ray.focus);
                EXPECT_LE(rest.t_near, ray.t_far);
                EXPECT_LT(ray.footprint.b, 0);
                EXPECT_GT(rest.footprint.b, 0);
                for (const accel::Ray& piece : {ray, rest})
                    EXPECT_NEAR(piece.footprint.at(ray.focus), rays.pixel().at(3), 1e-4f * rays.pixel().at(3));
            }
        }
}

// With so many samples, or so small a lens, that a beam does not narrow up to the focus, it is that of a pinhole camera.
TEST(CameraRays, OfASmallPartOfALensEndNowhere)
{
    Camera camera = Camera::look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1);
    camera.lens.radius = 0.05f;
    camera.lens.focus = 3;
    const float pixel = CameraRays(camera, 64, 32).pixel().at(3);
    const int most = static_cast<int>(std::floor((0.1f / pixel) * (0.1f / pixel)));
    EXPECT_TRUE(CameraRays(camera, 64, 32, most).ends_at_focus()) << most;
    const CameraRays rays(camera, 64, 32, most + 1);
    EXPECT_FALSE(rays.ends_at_focus());
    const accel::Ray ray = rays.ray(10, 20, Vec2f(0.9f, 0.1f));
    EXPECT_EQ(ray.t_far, std::numeric_limits<float>::infinity());
    EXPECT_EQ(ray.start_level, accel::kAnyLevel);
    EXPECT_EQ(ray.footprint.a, 0);
}

}  // namespace
}  // namespace occam::render
