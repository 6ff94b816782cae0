// The transfer curve of sRGB (IEC 61966-2-1).
#pragma once

#include "base/maths.h"

namespace occam {

inline float linear_from_srgb(float s) noexcept
{
    return s <= 0.04045f ? s / 12.92f : maths::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace occam
