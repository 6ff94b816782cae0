// The ways to interpolate between the keys of a channel: one row for each.
//
// To add a way, add its value to Channel::Interpolation, its row here and its case to evaluate() (scenegraph/animation.cpp).
#pragma once

#include <cstddef>
#include <string_view>

#include "scenegraph/animation.h"

namespace occam {

struct InterpolationRow {
    Channel::Interpolation mode;
    std::string_view name;     ///< in glTF
    std::size_t values_a_key;  ///< each of as many floats as the channel is wide; the middle one is the value itself
    std::size_t least_keys;
};
/// The rows stand in the order of the values.
inline constexpr InterpolationRow kInterpolations[] = {
    {Channel::Interpolation::Step, "STEP", 1, 1},
    {Channel::Interpolation::Linear, "LINEAR", 1, 1},
    {Channel::Interpolation::CubicSpline, "CUBICSPLINE", 3, 2},
};
constexpr const InterpolationRow& row_of(Channel::Interpolation mode) noexcept
{
    return kInterpolations[static_cast<std::size_t>(mode)];
}
consteval bool are_interpolations_in_order()
{
    std::size_t n = 0;
    for (const InterpolationRow& row : kInterpolations)
        if (static_cast<std::size_t>(row.mode) != n++) return false;
    return true;
}
static_assert(are_interpolations_in_order());

}  // namespace occam
