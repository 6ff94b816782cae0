// What the building of a tree of lights and the drawing from it share: bounds of powers, and cosines of sums of angles.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace occam::shade {

// Sums and quotients of powers within these bounds are finite and not zero.
inline constexpr float kLeastPower = 1e-30f, kMostPower = 1e30f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Bounds of cosines are floats: below minus this a light counts as turned away, and no factor is smaller than this.
inline constexpr float kMargin = 0.01f;

inline float sine_of(float cosine) noexcept { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); }

// Returns the cosine of a sum of two angles in [0, pi], or -1 if the sum is larger than pi.
inline float cosine_of_sum(float cos_a, float sin_a, float cos_b, float sin_b) noexcept
{
    return cos_a <= -cos_b ? -1 : cos_a * cos_b - sin_a * sin_b;
}

}  // namespace occam::shade
