// Rays through the image for pinhole, thin lens and orthographic cameras.
//
// Pixel (0, 0) is the top left one and its middle is (0.5, 0.5). Pixels are square, and the vertical field of view spans
// the height. Directions are computed in double and rounded once.
#pragma once

#include "accel/tracer.h"
#include "scenegraph/camera.h"
#include "shade/footprints.h"

namespace occam::render {

class CameraRays {
public:
    /// samples   number per pixel: a beam through a lens is as wide as one sample's part of the lens
    CameraRays(const Camera& camera, int width, int height, int samples = 1) noexcept;

    /// Returns the ray through a point of the image. Through a lens the ray ends at the focus, up to which its beam
    /// narrows; behind_focus() is the rest of it.
    /// x, y     in pixels of the whole frame
    /// lens     uniform in [0, 1): where the ray leaves the lens; it is not read for a pinhole camera
    accel::Ray ray(double x, double y, Vec2f lens = Vec2f(0.5f)) const noexcept;
    accel::Ray behind_focus(accel::Ray ray) const noexcept;
    bool has_lens() const noexcept { return lens_radius_ > 0; }

    /// Makes all further footprints those of another camera's pixels. The footprint of a ray at t is that of the other
    /// camera's pixel at the distance t plus the distance of the ray's start from that camera. It is never too narrow, and
    /// too wide by at most 2 |start - eye| / distance.
    void take_footprints_of(const CameraRays& other) noexcept;

    /// Returns camera z of a point: its distance along the view direction, not along the ray.
    double depth(Vec3d point) const noexcept { return glm::dot(point - eye_, forward_); }

    /// Returns the footprint of one pixel, from which the levels of a frame are chosen. It grows for a pinhole camera and
    /// is constant for an orthographic one.
    lod::Footprint pixel() const noexcept { return pixel_; }
    Vec3d eye() const noexcept { return eye_; }
    /// Returns the settings by which the frame's levels are chosen.
    lod::LevelSettings levels(float shading_rate) const noexcept;

private:
    shade::LensBeams lens_beams_of(const accel::Ray& ray) const noexcept;

    Vec3d eye_, forward_, right_, up_;  // right and up span half the height of the image
    double width_, height_;
    bool orthographic_, footprints_are_own_ = true;
    float lens_radius_ = 0, focus_ = 0;
    int blades_ = 0, samples_ = 1;
    lod::Footprint pixel_;
    lod::Footprint footprint_;  // measured from the eye of another camera, unless the footprints are the camera's own
};

}  // namespace occam::render
