// Tests of numbers that are too small or too large for their type.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/number_in.h"

namespace occam::test {
namespace {

TEST(NumberIn, IsZeroWhereANumberIsTooSmallAndNoneWhereItIsTooLarge)
{
    for (const std::string exponent : {"400", "9223372036854775807", "9223372036854775806", "9223372036854775808",
                                       "99999999999999999999999", "0009223372036854775807"})
        for (const std::string mantissa : {"1", "0.001", "100.5", "0.00000000000000000000001", "123456789012345678901234"}) {
            EXPECT_EQ(number_in<double>(mantissa + "e-" + exponent), 0) << mantissa << ", " << exponent;
            EXPECT_TRUE(std::signbit(number_in<double>("-" + mantissa + "e-" + exponent).value_or(1)));
            EXPECT_FALSE(number_in<double>(mantissa + "e" + exponent)) << mantissa << ", " << exponent;
        }
    EXPECT_EQ(number_in<float>("1e-60"), 0.0f);
    EXPECT_FALSE(number_in<float>("1e60"));
    // Digits before and behind the point count, too.
    EXPECT_EQ(number_in<double>("0." + std::string(400, '0') + "1"), 0);
    EXPECT_FALSE(number_in<double>("1" + std::string(400, '0')));
    EXPECT_EQ(number_in<double>("1" + std::string(400, '0') + "e-400"), 1);
}

}  // namespace
}  // namespace occam::test
