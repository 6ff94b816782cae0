// Colours that a file stores multiplied by alpha.
#pragma once

#include <algorithm>

#include "base/srgb.h"

namespace occam {

/// Returns the linear colour without alpha of a stored value that is multiplied by it. Where nothing is left of a colour, or
/// more is said to be there than all, the value stays as it is.
/// is_srgb   whether the value was encoded before it was multiplied, as whole numbers are; it is 0 to 1 then
inline float color_without_alpha(float value, float alpha, bool is_srgb)
{
    if (alpha > 0 && alpha < 1) value /= alpha;
    return is_srgb ? linear_from_srgb(std::min(value, 1.0f)) : value;
}

}  // namespace occam
