// Tests of the text of errors.
#include "base/error.h"

#include <gtest/gtest.h>

namespace occam::test {
namespace {

TEST(Error, IsOneLine)
{
    EXPECT_STREQ(Error("a\nb.obj", "the library says:\nfirst\r\n\nsecond\n", "line 1").what(),
                 "a; b.obj: the library says:; first; second;  (line 1)");
    EXPECT_STREQ(Error("", "only one\n").what(), "only one");
}

}  // namespace
}  // namespace occam::test
