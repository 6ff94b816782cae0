#include "base/maths.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

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

// A transform of a texture, a brush stroke or an environment may be turned by any number.
TEST(Maths, SinAndCosOfAnyNumberAreThoseOfAnAngle)
{
    for (float x = 1e6f; x < std::numeric_limits<float>::infinity(); x *= 1.7f)
        for (const float of : {x, -x}) {
            const double s = double(sin(of)), c = double(cos(of));
            EXPECT_NEAR(s * s + c * c, 1, 1e-6) << of;
            EXPECT_EQ(sin_cos(of).sin, sin(of)) << of;
            EXPECT_EQ(sin_cos(of).cos, cos(of)) << of;
        }
    EXPECT_TRUE(std::isnan(sin(std::numeric_limits<float>::infinity())));
    EXPECT_TRUE(std::isnan(cos(-std::numeric_limits<float>::infinity())));
}

TEST(Maths, SeveralNumbersAtOnceHaveTheBitsOfOneAtATime)
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    std::vector<float> x{0.0f,    -0.0f,     1,         -1,      0.5f,     -0.5f,     1e-40f,
                         -1e-30f, 0.999999f, -0.26795f, 0.2679f, 0.57735f, 1.0000001f};
    for (int i = -500; i <= 500; ++i) x.push_back(0.0131f * static_cast<float>(i));
    const auto same = [](float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); };
    std::vector<float> y(x.rbegin(), x.rend()), to(x.size()), sines(x.size()), cosines(x.size());
    sin_cos(x.data(), x.size(), sines.data(), cosines.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_TRUE(same(sines[i], sin(x[i])) && same(cosines[i], cos(x[i]))) << x[i];
    for (const float more : {kInfinity, -kInfinity, std::nanf("")}) {
        x.push_back(more);
        y.push_back(-1);
        x.push_back(2);
        y.push_back(more);
        x.push_back(more);
        y.push_back(kInfinity);
    }
    to.resize(x.size());
    atan2(y.data(), x.data(), x.size(), to.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_TRUE(same(to[i], atan2(y[i], x[i]))) << y[i] << ' ' << x[i];
    acos(x.data(), x.size(), to.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_TRUE(same(to[i], acos(x[i]))) << x[i];
}

TEST(Maths, AnglesAreThoseOfDoubles)
{
    for (int i = -1000; i <= 1000; ++i) {
        const float x = 1e-3f * static_cast<float>(i);
        EXPECT_NEAR(acos(x), std::acos(double(x)), 3e-7) << x;
        EXPECT_NEAR(asin(x), std::asin(double(x)), 2e-7) << x;
        EXPECT_NEAR(atan2(x, 0.3f), std::atan2(double(x), double(0.3f)), 2e-7) << x;
        EXPECT_NEAR(atan2(0.3f, x), std::atan2(double(0.3f), double(x)), 3e-7) << x;
    }
    EXPECT_EQ(atan2(0, 0), 0);
    EXPECT_EQ(atan2(0, -1), kPi);
    EXPECT_EQ(atan2(-1, 0), -kPi / 2);
    EXPECT_EQ(atan2(std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()), kPi / 4);
    EXPECT_EQ(acos(2), 0);
    EXPECT_EQ(acos(-2), kPi);
}

}  // namespace
}  // namespace occam::maths
