// Tests of vectors in lanes as the compiler makes them: this file is compiled with the options of the tests, -O1 among them.
#include <gtest/gtest.h>

#include "base/simd.h"

namespace occam {
namespace {

/// Returns the largest of the first eight of sixteen floats, if those are not negative.
__attribute__((noinline)) float largest_of_first_half(const float* from)
{
    alignas(32) static constexpr float kFirstHalf[16] = {1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0};
    return largest(vfloat4x4::load(from) * vfloat4x4::load(kFirstHalf));
}

/// Returns the largest of the first twelve of sixteen floats, if those are not negative.
__attribute__((noinline)) float largest_without_last_row(const float* from)
{
    alignas(32) static constexpr float kNotLastRow[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    return largest(vfloat4x4::load(from) * vfloat4x4::load(kNotLastRow));
}

// g++ 12 takes the upper half of the second constant for ones if it may copy 32 bytes at a time (-mmove-max=256).
TEST(Lanes, ConstantsKeepTheirZeros)
{
    alignas(32) float numbers[16];
    for (int i = 0; i < 16; ++i) numbers[i] = float(i);
    EXPECT_EQ(largest_of_first_half(numbers), 7);
    EXPECT_EQ(largest_without_last_row(numbers), 11);
}

}  // namespace
}  // namespace occam
