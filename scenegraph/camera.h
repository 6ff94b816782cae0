// A camera: where it is in the world, its whole vertical angle, and its lens if it is no pinhole.
#pragma once

#include "base/box.h"

namespace occam {

/// What a camera node of the scene holds; it looks along its node's -z, y up.
struct CameraLens {
    float fov = 0.69f;  ///< whole vertical angle, radians; of a perspective camera
    float aspect = 0;   ///< width over height; 0: that of the image
    bool orthographic = false;
    float height = 2;  ///< whole height in world units, orthographic only
    float radius = 0;  ///< of the thin lens, world units; 0: a pinhole, all is sharp
    float focus = 0;   ///< camera z of what is sharp, world units; of a lens above 0
    int blades = 0;    ///< corners of the lens's opening; fewer than 3: round
};

/// A camera as a frame needs it. World axes, unit world length.
struct Camera {
    Mat4d world_from_camera{1};  ///< rigid: right, up, back, eye
    CameraLens lens;

    Vec3d eye() const noexcept { return Vec3d(world_from_camera[3]); }

    static Camera look_at(Vec3d eye, Vec3d target, Vec3d up, float fov);
    /// Sees all of `bounds` from the front, a little from above and the right, with a margin of a tenth.
    static Camera framing(const Box3d& bounds, float aspect = 16.0f / 9.0f);
};

}  // namespace occam
