// Rays through the image for pinhole, thin lens and orthographic cameras.
//
// Pixel (0, 0) is the top left one and its middle is (0.5, 0.5). Pixels are square, and the vertical field of view spans
// the height. Directions are computed in double and rounded once.
//
// Time     from 0 (the shutter opens) to 1 (it closes). What takes no time is about the camera at mid-shutter.
#pragma once

#include <vector>

#include "accel/tracer.h"
#include "scenegraph/camera.h"
#include "shade/footprints.h"

namespace occam::render {

class CameraRays {
public:
    /// samples        number per pixel: a beam through a lens is as wide as one sample's part of the lens
    /// shading_rate   that of levels(): decides the level of detail at the focus of a lens
    CameraRays(const Camera& camera, int width, int height, int samples = 1, float shading_rate = 1);

    /// Returns the ray through a point of the image. If its beam narrows towards the focus of a lens, the ray ends there;
    /// behind_focus() is the rest of it. At the focus both see cages at one level.
    /// x, y     in pixels of the whole frame
    /// lens     uniform in [0, 1): where the ray leaves the lens; it is not read for a pinhole camera
    /// time     the moment at which the ray sees the scene, and at which the camera is where it starts
    accel::Ray ray(double x, double y, Vec2f lens = Vec2f(0.5f), float time = 0) const noexcept;
    accel::Ray behind_focus(accel::Ray ray) const noexcept;
    bool has_lens() const noexcept { return lens_radius_ > 0; }
    /// Returns whether rays end at the focus. A beam does not narrow up to there if one sample's part of the lens is no
    /// wider than a pixel is at the focus. It is then taken for the beam of a pinhole camera, whose width behind the focus
    /// is at least half of its own.
    bool ends_at_focus() const noexcept
    {
        return has_lens() && footprints_are_own_ && shade::lens_share(2 * lens_radius_, samples_) > pixel_.at(focus_);
    }
    /// Returns whether the camera moves while the shutter is open.
    bool moves() const noexcept { return !keys_.empty(); }

    /// Makes all further footprints those of another camera's pixels. The footprint of a ray at t is that of the other
    /// camera's pixel at the distance t plus the distance of the ray's start from that camera. It is never too narrow, and
    /// too wide by at most 2 |start - eye| / distance.
    void take_footprints_of(const CameraRays& other) noexcept;

    /// Returns camera z of a point: its distance along the view direction, not along the ray.
    double depth(Vec3d point) const noexcept { return glm::dot(point - middle_.eye, middle_.forward); }
    double depth(Vec3d point, float time) const noexcept;

    /// Returns how fast the picture of a point moves to the right and down: pixels per shutter. It is 0 for a point behind
    /// the camera.
    /// velocity   of the point: world length per shutter
    Vec2d pixel_velocity(Vec3d point, Vec3d velocity, float time) const noexcept;

    /// Returns the footprint of one pixel, from which the levels of a frame are chosen. It grows for a pinhole camera and
    /// is constant for an orthographic one.
    lod::Footprint pixel() const noexcept { return pixel_; }
    Vec3d eye() const noexcept { return middle_.eye; }
    /// Returns the settings by which the frame's levels are chosen.
    lod::LevelSettings levels(float shading_rate) const;

private:
    /// Holds where the camera is and how it is turned.
    struct View {
        Vec3d eye, forward;  ///< forward has unit length
        Vec3d right, up;     ///< they span half the height of the image; unit vectors in keys_
    };
    View view_of(const Mat4d& world_from_camera, double half) const noexcept;
    View view_at(double time) const noexcept;
    Vec2d place_in_image(const View& view, Vec3d point) const noexcept;
    shade::LensBeams lens_beams_of(const accel::Ray& ray) const noexcept;

    double width_, height_;
    double half_ = 1;  ///< half the height of the image, at camera z of 1 for a perspective camera
    View middle_;
    std::vector<View> keys_;  ///< at evenly spaced moments; empty: the camera stands still
    bool orthographic_, footprints_are_own_ = true;
    float lens_radius_ = 0, focus_ = 0;
    int blades_ = 0, samples_ = 1;
    std::int8_t level_at_focus_ = accel::kAnyLevel;
    lod::Footprint pixel_;
    lod::Footprint footprint_;  // measured from the eye of another camera, unless the footprints are the camera's own
};

}  // namespace occam::render
