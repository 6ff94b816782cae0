#include "base/maths.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace occam::maths {
namespace {

TEST(Maths, SinCosHasTheBitsOfSinAndCos)
{
    const auto check = [](float x) {
        const SinCos both = sin_cos(x);
        EXPECT_EQ(std::bit_cast<std::uint32_t>(both.sin), std::bit_cast<std::uint32_t>(sin(x))) << x;
        EXPECT_EQ(std::bit_cast<std::uint32_t>(both.cos), std::bit_cast<std::uint32_t>(cos(x))) << x;
    };
    for (int i = -2000; i <= 2000; ++i) check(0.01f * static_cast<float>(i));
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const float x : {0.0f, 1e6f, 1e19f, 3e38f, 1e-40f, kInfinity, -kInfinity, std::nanf("")}) {
        check(x);
        check(-x);
    }
}

TEST(Maths, SinAndCosAreThoseOfDoubles)
{
    for (int i = -4000; i <= 4000; ++i) {
        const float x = 0.25f * static_cast<float>(i) + 1e-3f;
        EXPECT_NEAR(sin(x), std::sin(double(x)), 6e-8) << x;
        EXPECT_NEAR(cos(x), std::cos(double(x)), 6e-8) << x;
    }
}

}  // namespace
}  // namespace occam::maths
