// Fits a camera to a set of points, so that they fill its picture.
#pragma once

#include "scenegraph/camera.h"

namespace occam {

/// The side from which a scene without a camera is viewed. If y or x points up, the front faces +z (glTF 2.0, sec. 3.4); if
/// z points up, it faces -y, as in modelling programs.
enum class ViewFrom : unsigned char {
    ThreeQuarter,  ///< from the front, a little from above and from the right
    Front,
    Side,  ///< from the viewer's right
    Back,
    Top,
    Bottom
};

/// Finds the nearest position of a camera of fixed direction that has all points in its picture, with a narrow margin.
///
/// Each of the four sides of the view frustum is a plane of fixed slope, so only the largest offset of any point beyond that
/// plane matters. These are a few numbers, whatever the number of points and their order.
class CameraFit {
public:
    /// fov      full vertical angle in radians
    /// aspect   width over height of the picture
    /// Throws Error if `up` is zero or not finite, for a side that does not exist, for an angle that is not from
    /// kNarrowestView to kWidestView, and for an aspect that is not finite and above 0.
    CameraFit(ViewFrom side, Vec3d up, float fov, float aspect);

    /// Adds a point in world axes. A point that is not finite is ignored.
    void add(Vec3d point) noexcept;
    bool is_empty() const noexcept { return box_.is_empty(); }
    /// Returns the camera. It looks at the unit box around the origin if no point was added.
    Camera camera() const;
    /// Removes all points.
    void clear() noexcept;

private:
    Vec3d right_, up_, back_;  ///< the camera's axes
    double slope_x_, slope_y_;
    float fov_;
    Box3d box_;                                         ///< bounds of the points, camera axes
    double right_most_, left_most_, highest_, lowest_;  ///< offsets of the frustum's sides
};

}  // namespace occam
