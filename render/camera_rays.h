// Rays through the image: pinhole, thin lens and orthographic.
//
// Pixel (0, 0) is the top left one and its middle is (0.5, 0.5); pixels are square, and the vertical angle covers the
// height. Directions are computed in double and rounded once.
#pragma once

#include "accel/tracer.h"
#include "scenegraph/camera.h"
#include "shade/footprints.h"

namespace occam::render {

class CameraRays {
public:
    /// samples   of a pixel: a beam through a lens is as wide as one sample's part of it
    CameraRays(const Camera& camera, int width, int height, int samples = 1) noexcept;

    /// x, y     in pixels of the whole frame
    /// lens     uniform in [0, 1): where the ray leaves the lens. Not read for a pinhole
    /// Through a lens the ray ends at the focus, up to which its beam narrows: behind_focus() is the rest of it.
    accel::Ray ray(double x, double y, Vec2f lens = Vec2f(0.5f)) const noexcept;
    accel::Ray behind_focus(accel::Ray ray) const noexcept;
    bool has_lens() const noexcept { return lens_radius_ > 0; }

    /// From now on footprints are those that another camera's pixels have: at t of a ray, its pixel at the distance of the
    /// ray's start from it, plus t. That is never too narrow, and too wide by at most 2 |start - eye| / distance.
    void take_footprints_of(const CameraRays& other) noexcept;

    /// Camera z of a point: its distance along the view, not along the ray.
    double depth(Vec3d point) const noexcept { return glm::dot(point - eye_, forward_); }

    /// Width of one pixel's beam: what a frame's levels are chosen from. Growing for a pinhole, constant if orthographic.
    lod::Footprint pixel() const noexcept { return pixel_; }
    Vec3d eye() const noexcept { return eye_; }
    /// By which the frame's levels are chosen.
    lod::LevelSettings levels(float shading_rate) const noexcept;

private:
    shade::LensBeams lens_beams_of(const accel::Ray& ray) const noexcept;

    Vec3d eye_, forward_, right_, up_;  // right and up: of half the image's height
    double width_, height_;
    bool orthographic_, footprints_are_own_ = true;
    float lens_radius_ = 0, focus_ = 0;
    int blades_ = 0, samples_ = 1;
    lod::Footprint pixel_;
    lod::Footprint footprint_;  // from the eye on: another camera's, unless they are its own
};

}  // namespace occam::render
