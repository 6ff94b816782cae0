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

// A terminal may take these for other characters, for controls among them (Unicode 15, table 3-7).
TEST(Error, HoldsNoFormsOfUtf8ThatAreNotAllowed)
{
    EXPECT_STREQ(Error("", "\xc0\x9b \xe0\x82\x9b \xf0\x80\x82\x9b").what(),
                 "\\xc0\\x9b \\xe0\\x82\\x9b \\xf0\\x80\\x82\\x9b")
        << "overlong";
    EXPECT_STREQ(Error("", "\xed\xa0\x80 \xed\xbf\xbf").what(), "\\xed\\xa0\\x80 \\xed\\xbf\\xbf") << "surrogates";
    EXPECT_STREQ(Error("", "\xf4\x90\x80\x80 \xf5\x80\x80\x80").what(), "\\xf4\\x90\\x80\\x80 \\xf5\\x80\\x80\\x80")
        << "above U+10FFFF";
    const char* at_the_limits = "\u0800 \ud7ff \ue000 \uffff \U00010000 \U0010ffff";
    EXPECT_STREQ(Error("", at_the_limits).what(), at_the_limits);
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
