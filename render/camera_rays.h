// Rays through the image: pinhole and orthographic.
//
// Pixel (0, 0) is the top left one and its middle is (0.5, 0.5); pixels are square, and the vertical angle covers the
// height. Directions are computed in double and rounded once.
#pragma once

#include "accel/tracer.h"
#include "scenegraph/camera.h"

namespace occam::render {

class CameraRays {
public:
    CameraRays(const Camera& camera, int width, int height) noexcept;

    /// x, y     in pixels of the whole frame
    accel::Ray ray(double x, double y) const noexcept;

    /// Camera z of a point: its distance along the view, not along the ray.
    double depth(Vec3d point) const noexcept { return glm::dot(point - eye_, forward_); }

    /// Width of one pixel's beam: what a frame's levels are chosen from. Growing for a pinhole, constant if orthographic.
    lod::Footprint pixel() const noexcept { return pixel_; }
    Vec3d eye() const noexcept { return eye_; }
    /// By which the frame's levels are chosen.
    lod::LevelSettings levels(float shading_rate) const noexcept;

private:
    Vec3d eye_, forward_, right_, up_;  // right and up: of half the image's height
    double width_, height_;
    bool orthographic_;
    lod::Footprint pixel_;
};

}  // namespace occam::render
