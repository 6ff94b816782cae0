// Elementary functions that give the same bits on every machine. Those of the C library differ by version and processor.
//
// They use plain double arithmetic (series after range reduction, with a relative error below 1e-12) and round to float once
// at the end, so they are nearly always correctly rounded. No contraction is allowed here (cmake/Flags.cmake).
#pragma once

#include <cstddef>

namespace occam::maths {

inline constexpr float kPi = 3.14159265358979f;

/// Takes radians, of any size: up to 1e6 it is precise, and beyond that accuracy falls, but the result is one of an angle.
/// NaN for infinities.
float sin(float x) noexcept;
float cos(float x) noexcept;
/// Holds the sine and the cosine of one angle, with the bits of sin() and cos().
struct SinCos {
    float sin, cos;
};
SinCos sin_cos(float x) noexcept;
float tan(float x) noexcept;
float exp2(float x) noexcept;  ///< 0 for x <= -150, infinity for x >= 128
float exp(float x) noexcept;
float log2(float x) noexcept;  ///< -infinity at 0, NaN below 0
float log(float x) noexcept;
float pow(float x, float y) noexcept;  ///< for x >= 0; pow(0, y > 0) = 0, pow(x, 0) = 1; NaN for x < 0
float atan2(float y, float x) noexcept;
float acos(float x) noexcept;  ///< x is clamped to [-1, 1]
float asin(float x) noexcept;

// These do the same for `count` numbers, with the same bits, and the compiler makes them of SIMD instructions.
void sin_cos(const float* x, std::size_t count, float* sin, float* cos) noexcept;  ///< of at most 1e6 in size, and finite
void atan2(const float* y, const float* x, std::size_t count, float* to) noexcept;
void acos(const float* x, std::size_t count, float* to) noexcept;

}  // namespace occam::maths
