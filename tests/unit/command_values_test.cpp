#include "command/values.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace occam::command {
namespace {

TEST(CommandValues, SizesOfMemoryArePowersOf1024)
{
    EXPECT_EQ(bytes_of("4096"), 4096u);
    EXPECT_EQ(bytes_of("512M"), 512u << 20);
    EXPECT_EQ(bytes_of("2G"), std::size_t(2) << 30);
    EXPECT_EQ(bytes_of("1.5k"), 1536u);
    for (const char* bad : {"", "M", "-1G", "0", "1Q", "1e99G", "nan", "2 G"})
        EXPECT_THROW(bytes_of(bad), std::invalid_argument) << bad;
}

TEST(CommandValues, PictureSizesAreTwoNumbers)
{
    EXPECT_EQ(size_of("1280x720"), std::make_pair(1280, 720));
    for (const char* bad : {"", "12", "x", "12x", "x12", "-1x5", "0x5", "1x2x3", "99999999999x1"})
        EXPECT_THROW(size_of(bad), std::invalid_argument) << bad;
}

TEST(CommandValues, ListsHaveAsManyNumbersAsAskedFor)
{
    EXPECT_EQ(numbers_of("1,-2.5,3e2", 3), (std::vector<double>{1, -2.5, 300}));
    for (const char* bad : {"", "1,2", "1,2,3,4", "1,,3", "1,2,x", "1,2,inf", "1,2,nan", "1, 2,3"})
        EXPECT_THROW(numbers_of(bad, 3), std::invalid_argument) << bad;
}

TEST(CommandValues, SwitchesAreOnOrOff)
{
    EXPECT_TRUE(is_on("on"));
    EXPECT_FALSE(is_on("off"));
    EXPECT_THROW(is_on("yes"), std::invalid_argument);
}

}  // namespace
}  // namespace occam::command
