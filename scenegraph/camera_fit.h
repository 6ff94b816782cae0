// A camera that has a cloud of points in its picture, as large as it can be.
#pragma once

#include "scenegraph/camera.h"

namespace occam {

/// The side from which a scene without a camera is looked at. With y or x up the front faces +z (glTF 2.0, sec. 3.4); with z
/// up it faces -y, as in modelling programs.
enum class ViewFrom : unsigned char {
    ThreeQuarter,  ///< from the front, a little from above and from the right
    Front,
    Side,  ///< from the viewer's right
    Back,
    Top,
    Bottom
};

/// Finds the nearest place of a camera of fixed direction that has all points in its picture, with a narrow margin.
///
/// Each of the four sides of the view frustum is a plane of fixed slope, so that only the largest distance of any point
/// beyond it matters: a few numbers, whatever the number of points and their order.
class CameraFit {
public:
    /// fov      whole vertical angle, radians
    /// aspect   width over height of the picture
    /// Throws Error for an `up` without length, or an angle that is not between 0 and pi.
    CameraFit(ViewFrom side, Vec3d up, float fov, float aspect);

    /// World axes. Ignores a point that is not finite.
    void add(Vec3d point) noexcept;
    bool is_empty() const noexcept { return box_.is_empty(); }
    /// Looks at the unit box about the origin if no point was added.
    Camera camera() const;
    /// Forgets the points.
    void clear() noexcept;

private:
    Vec3d right_, up_, back_;  ///< the camera's axes
    double slope_x_, slope_y_;
    float fov_;
    Box3d box_;                                         ///< of the points, camera axes
    double right_most_, left_most_, highest_, lowest_;  ///< offsets of the frustum's sides
};

}  // namespace occam
