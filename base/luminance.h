// The luminance of linear colours with the primaries of sRGB (ITU-R BT.709).
#pragma once

#include "base/vec.h"

namespace occam {

inline float luminance(Vec3f c) noexcept { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
inline double luminance(Vec3d c) noexcept { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

}  // namespace occam
