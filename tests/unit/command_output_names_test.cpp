// Tests of outputs with names of every kind: nothing that is there may be lost.
#include <algorithm>
#include <iterator>

#include "io/output_file.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class OutputNames : public CommandTest {};

// The temporary files of killed runs are removed by the name of their output. No name means no file.
TEST_F(OutputNames, WithoutALastPartLoseNoFiles)
{
    const fs::path kept = folder / "kept";
    fs::create_directory(kept);
    for (const char* name : {"notes.txt", ".hidden", "a.png", ".part", ".part1", "part7.png"})
        std::ofstream(kept / name) << name;
    const auto count = [](const fs::path& where) {
        return std::distance(fs::directory_iterator(where), fs::directory_iterator());
    };
    const auto before = count(folder), in_kept = count(kept);
    const fs::path names[] = {"", folder / "", kept / "", kept / ".", kept / "..", folder};
    for (const fs::path& name : names) remove_unfinished(std::span(&name, 1));
    remove_unfinished(names);
    EXPECT_EQ(count(kept), in_kept);
    EXPECT_EQ(count(folder), before);
    const std::vector<std::string> calls[] = {{"render", "triangle.obj", "-o", ""},
                                              {"render", "triangle.obj", "-o", "kept/"},
                                              {"render", "triangle.obj", "-o", "./"},
                                              {"render", "triangle.obj", "-o", "."},
                                              {"render", "triangle.obj", "-o", "a.png", "--stats", "kept/"},
                                              {"animate", "triangle.obj", "-o", "####/", "--frames", "0-1"},
                                              {"animate", "triangle.obj", "-o", "kept/a.####.png", "--stats", "./"}};
    for (const std::vector<std::string>& words : calls) {
        const Outcome o = run(words);
        EXPECT_TRUE(o.exit_code == kBadInput || o.exit_code == kOutput) << words[3] << o.exit_code;
        EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
        EXPECT_EQ(count(kept), in_kept) << words[3];
        EXPECT_EQ(count(folder), before + 2) << words[3] << ": the two files are those of the streams";
    }
}

}  // namespace
}  // namespace occam
