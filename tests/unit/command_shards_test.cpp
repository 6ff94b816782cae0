// Tests of parts of a sequence that has fewer frames than parts.
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class ShardWithoutFrames : public CommandTest {
protected:
    Outcome outcome(const char* shard, const std::string& pattern, const std::vector<std::string>& more,
                    const std::string& scene = "triangle.obj") const
    {
        std::vector<std::string> words{"animate", scene,   "-o",    pattern, "--frames", "0-1",
                                       "--size",  "16x12", "--spp", "1",     "--shard",  shard};
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    }
};

// A farm learns from the first part that ends, whichever that is.
TEST_F(ShardWithoutFrames, IsCheckedAsOthersAre)
{
    struct Call {
        std::string pattern;
        std::vector<std::string> more;
        std::string scene = "triangle.obj";
    };
    std::ofstream(folder / "mine.json") << "mine";
    const Call calls[] = {{"a.####.xyz", {}},
                          {"missing/a.####.exr", {}},
                          {"a.####.exr", {}, "missing.obj"},
                          {"a.####.exr", {"--environment", "missing.exr"}},
                          {"a.####.exr", {"--stats", "missing/s.json"}},
                          {"a.####.exr", {"--stats", "mine.json"}},
                          {"a.####.exr", {"--stats", "a.0000.exr"}},
                          {"a.####.exr", {}, "mine.json"}};
    for (const auto& [pattern, more, scene] : calls) {
        const Outcome with = outcome("1/3", pattern, more, scene), without = outcome("3/3", pattern, more, scene);
        EXPECT_NE(without.exit_code, kDone) << without.err;
        EXPECT_EQ(without.exit_code, with.exit_code) << pattern;
        EXPECT_EQ(without.err, with.err);
    }
}

TEST_F(ShardWithoutFrames, EndsAtOnceAndSaysSo)
{
    const Outcome o = outcome("3/3", "a.#.exr", {"--stats", "s.json"});
    EXPECT_EQ(o.exit_code, kDone);
    EXPECT_EQ(o.err, "occam: part 3 of 3 of the sequence has no frames: nothing to do\n");
    EXPECT_EQ(text_of(folder / "s.json"), "[]\n");
    EXPECT_FALSE(fs::exists(folder / "a.0.exr"));
    EXPECT_EQ(outcome("3/3", "a.#.exr", {"-q"}).err, "");
}

}  // namespace
}  // namespace occam
