// A camera: its transform to the world, its full vertical field of view, and its lens unless it is a pinhole.
#pragma once

#include <vector>

#include "base/box.h"

namespace occam {

/// The range of a perspective camera's angle, radians. Directions of rays are floats, whose steps, 6e-8, are then less than
/// a hundredth of the picture's height.
inline constexpr float kNarrowestView = 1e-5f, kWidestView = 3.14f;

/// Holds the properties of a camera node. The camera looks along its node's -z axis, and y points up.
struct CameraLens {
    float fov = 0.69f;  ///< full vertical angle in radians, from kNarrowestView to kWidestView, perspective only
    /// Width over height of the picture that it is meant for, 0 if any. A picture has the ratio of its own size.
    float aspect = 0;
    bool orthographic = false;
    float height = 2;  ///< full height in world units, orthographic only
    float radius = 0;  ///< radius of the thin lens in world units; 0: a pinhole, and everything is sharp
    float focus = 0;   ///< distance along the camera's axis that is in focus, in world units; 0: everything is sharp
    int blades = 0;    ///< number of aperture blades; fewer than 3: a round aperture
};

/// The largest number of a camera's keys.
inline constexpr std::size_t kMaxCameraKeys = 1025;

/// A camera as a frame needs it, in world axes and world lengths.
struct Camera {
    Mat4d world_from_camera{1};  ///< rigid; its columns are right, up, back and eye; of mid-shutter if the camera moves
    CameraLens lens{};
    /// world_from_camera at evenly spaced moments, from when the shutter opens to when it closes: at least two, or none if
    /// the camera stands still. Between two of them the elements are interpolated, and the axes brought back to unit length.
    std::vector<Mat4d> keys{};

    Vec3d eye() const noexcept { return Vec3d(world_from_camera[3]); }

    /// Returns a camera that looks from `eye` to `target`. `up` may have any length, and decides what is above unless the
    /// camera looks along it. Throws Error if eye and target are the same or not finite, if `up` is zero or not finite, and
    /// for an angle that is not from kNarrowestView to kWidestView.
    static Camera look_at(Vec3d eye, Vec3d target, Vec3d up, float fov);
    /// Returns a camera that sees all of `bounds` from the front, a little from above and the right, with a margin of a
    /// tenth. Throws Error if the aspect, width over height of the picture, is not finite and above 0, and if the bounds are
    /// not finite.
    static Camera framing(const Box3d& bounds, float aspect = 16.0f / 9.0f);
};

/// Returns whether a camera that looks along `view` cannot tell by `up` what is above: they are parallel, or one is zero.
bool is_along(Vec3d view, Vec3d up) noexcept;

/// When the shutter opens and closes, in frames from the frame's own time: -0.25 and 0.25 are half a frame around it.
struct Shutter {
    double open = 0, close = 0;

    double length() const noexcept { return close - open; }
    /// Returns false for a shutter that opens and closes at the same moment: the picture is that of the moment.
    bool is_open() const noexcept { return close > open; }
    friend bool operator==(const Shutter&, const Shutter&) = default;
};
/// The farthest moment from a frame's own time, in frames.
inline constexpr double kMaxShutterFrames = 1e6;

}  // namespace occam
