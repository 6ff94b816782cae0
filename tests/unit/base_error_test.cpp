// Tests of the text of errors.
#include "base/error.h"

#include <gtest/gtest.h>

#include <string>

namespace occam::test {
namespace {

TEST(Error, IsOneLine)
{
    EXPECT_STREQ(Error("a\nb.obj", "the library says:\nfirst\r\n\nsecond\n", "line 1").what(),
                 "a; b.obj: the library says:; first; second;  (line 1)");
    EXPECT_STREQ(Error("", "only one\n").what(), "only one");
}

// The name of a file, and what a file says, may hold anything. A terminal must not obey it.
TEST(Error, HoldsNoControlCharacters)
{
    EXPECT_STREQ(Error("a\x1b[31m.obj", "\x07 bell\x7f and\ttab", "node '\xc2\x9b'").what(),
                 "a\\x1b[31m.obj: \\x07 bell\\x7f and tab (node '\\xc2\\x9b')");
    EXPECT_STREQ(Error("\xff\xfe.obj", "\xe2\x80\xa8 \xed\xc3").what(), "\\xff\\xfe.obj: \\xe2\\x80\\xa8 \\xed\\xc3");
    EXPECT_STREQ(Error("Caf\u00e9/\u6a21\u578b/\U0001f600.obj", "is missing").what(),
                 "Caf\u00e9/\u6a21\u578b/\U0001f600.obj: is missing");
}

TEST(Error, IsShortWhateverItNames)
{
    std::string name;
    for (int i = 0; i < 40'000; ++i) name += "\u00e9";
    const std::string line = Error(name + ".obj", "has no end", name).what();
    EXPECT_LT(line.size(), 2100u);
    EXPECT_TRUE(line.starts_with("\u00e9\u00e9") && line.ends_with("\u00e9)")) << line;
    EXPECT_EQ(line.find("\\x"), std::string::npos) << "a letter was cut in two";
    EXPECT_NE(Error("a.obj", "has no end", name).what(), line);
    EXPECT_TRUE(std::string(Error("a.obj", "has no end", name).what()).starts_with("a.obj: has no end ("));
}

}  // namespace
}  // namespace occam::test
