// Tests of what the README tells a reader to paste.
#include <algorithm>
#include <sstream>

#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

// Returns the words of each line of the README that calls the program, in their order, without comments.
std::vector<std::vector<std::string>> lines_of_readme()
{
    std::ifstream in(fs::path(OCCAM_SOURCE_DIR) / "README.md");
    std::vector<std::vector<std::string>> lines;
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line.substr(0, line.find(" #")));
        std::string word;
        if (!(words >> word) || word != "build/demo/occam") continue;
        lines.emplace_back();
        while (words >> word) lines.back().push_back(word);
    }
    return lines;
}

// Returns the same line with fewer pixels, samples, frames and rays.
std::vector<std::string> made_small(const std::vector<std::string>& line)
{
    std::vector<std::string> words;
    for (std::size_t i = 0; i < line.size(); ++i) {
        // An error can be estimated from many samples only.
        if (line[i] == "--error" || line[i] == "--size" || line[i] == "--spp" || line[i] == "--rays" ||
            line[i] == "--frames")
            ++i;
        else words.push_back(line[i]);
    }
    const bool is_help = std::find(line.begin(), line.end(), "--help") != line.end();
    if (!is_help && (line[0] == "render" || line[0] == "animate"))
        words.insert(words.end(), {"--size", "32x18", "--spp", "1"});
    if (line[0] == "animate") words.insert(words.end(), {"--frames", "0-1"});
    if (line[0] == "verify") words.insert(words.end(), {"--rays", "1000"});
    return words;
}

TEST_F(CommandTest, EveryLineOfTheReadmeWorks)
{
    fs::create_directory_symlink(fs::path(OCCAM_SOURCE_DIR) / "samples", folder / "samples");
    const auto lines = lines_of_readme();
    EXPECT_GE(lines.size(), 8u);
    for (const auto& line : lines) {
        std::string text;
        for (const std::string& word : line) text += word + " ";
        const Outcome o = run(made_small(line));
        EXPECT_EQ(o.exit_code, kDone) << text << '\n' << o.err;
    }
    EXPECT_TRUE(fs::exists(folder / "swim.0001.png"));
}

}  // namespace
}  // namespace occam
