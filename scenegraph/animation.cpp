#include "scenegraph/animation.h"

namespace occam {

// glTF 2.0, sec. 3.5.3: scale, then rotation, then translation.
Mat4d Trs::matrix() const noexcept
{
    const double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
    const Vec3d right(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
    const Vec3d up(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
    const Vec3d back(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
    return {Vec4d(right * scale.x, 0), Vec4d(up * scale.y, 0), Vec4d(back * scale.z, 0), Vec4d(translation, 1)};
}

}  // namespace occam
