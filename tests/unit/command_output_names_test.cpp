// Tests of outputs with names of every kind: nothing that is there may be lost.
#include <algorithm>
#include <iterator>

#include "io/output_file.h"
#include "render/image.h"
#include "tests/support/campaign.h"
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

// The names of temporaries are longer than those of outputs, but not longer than a file system takes.
TEST_F(OutputNames, AreAsLongAsTheFileSystemTakesThem)
{
    const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> words{"render", "triangle.obj", "-o", name, "--size", "4x4", "--spp", "1"};
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    };
    const std::string longest = std::string(251, 'a') + ".exr", too_long = "a" + longest;
    const std::string accents = std::string(1, 'a') + [] {
        std::string text;
        for (int i = 0; i < 125; ++i) text += "\xc3\xa9";
        return text;
    }() + ".exr";
    const std::string stats = "s." + std::string(253, 'j');
    for (const std::string& name : {longest, accents}) {
        const Outcome o = render(name, {"--stats", stats});
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        EXPECT_TRUE(fs::exists(folder / name));
        EXPECT_TRUE(fs::exists(folder / stats));
    }
    const Outcome refused = render(too_long, {});
    EXPECT_EQ(refused.exit_code, kOutput);
    EXPECT_NE(refused.err.find("cannot be written: File name too long"), std::string::npos) << refused.err;
    // Those of killed runs are found again. Names that begin alike are told apart.
    for (const std::string& name : {longest, accents, stats}) {
        const fs::path file = folder / name;
        const std::string other_name = name.substr(0, name.size() - 5) + "b" + name.substr(name.size() - 4);
        fs::path temporary, other;
        {
            const OutputFile out(file), out_of_other(folder / other_name);
            temporary = out.temporary(), other = out_of_other.temporary();
        }
        EXPECT_NE(temporary, other);
        std::ofstream(temporary) << "half";
        std::ofstream(other) << "half";
        remove_unfinished(std::span(&file, 1));
        EXPECT_FALSE(fs::exists(temporary)) << name;
        EXPECT_TRUE(fs::remove(other)) << name;
    }
}

// Files that have the name of a checkpoint need not be one.
TEST_F(OutputNames, AFileOfSomebodyElseIsNoCheckpoint)
{
    const auto words = [](std::initializer_list<std::string> more) {
        std::vector<std::string> all{"render", "triangle.obj", "-o", "a.exr", "--size", "8x4", "--spp", "1"};
        all.insert(all.end(), more);
        return all;
    };
    const fs::path file = folder / "a.exr.checkpoint";
    EveryNth some(2);
    for (const char* text : {"mine", "", "Occam 0.1.0, recipe of the day\n", "\n", "Occam 1, recipe 0123456789abcdefg\n"}) {
        std::ofstream(file, std::ios::binary) << text;
        EXPECT_EQ(run(words({})).exit_code, kDone) << text;
        EXPECT_TRUE(fs::exists(file)) << "a finished picture leaves it alone: " << text;
        EXPECT_TRUE(fs::remove(folder / "a.exr"));
        for (const char* option : {"--resume", "--deadline=1e-9", "--checkpoint=on"}) {
            if (!some.takes()) continue;
            const Outcome o = run(words({option}));
            EXPECT_EQ(o.exit_code, kBadInput) << option;
            EXPECT_EQ(o.err.find("occam: a.exr.checkpoint: is there already and is no checkpoint"), 0u) << o.err;
            EXPECT_FALSE(fs::exists(folder / "a.exr")) << "found before the picture is made";
        }
        EXPECT_EQ(text_of(file), text);
    }
    fs::remove(file);
    ASSERT_EQ(run(words({"--deadline", "1e-9"})).exit_code, kDone);
    ASSERT_TRUE(fs::exists(file));
    EXPECT_EQ(run(words({})).exit_code, kDone);
    EXPECT_FALSE(fs::exists(file)) << "a checkpoint is removed by the finished picture";
}

TEST_F(OutputNames, ACheckpointOutlastsOtherPicturesOfItsName)
{
    const std::vector<std::string> slow{"render", "triangle.obj", "-o", "a.exr", "--size", "16x8", "--deadline", "1e-9"};
    ASSERT_EQ(run(slow).exit_code, kDone);
    const std::string checkpoint = text_of(folder / "a.exr.checkpoint");
    ASSERT_FALSE(checkpoint.empty());
    const std::string line = "occam: a.exr.checkpoint is that of another picture and stays";
    const std::vector<std::string> quick{"render", "triangle.obj", "-o", "a.exr", "--size", "8x4", "--spp", "1"};
    const Outcome finished = run(quick);
    EXPECT_EQ(finished.exit_code, kDone);
    EXPECT_EQ(finished.err, line + "\n");
    EXPECT_TRUE(text_of(folder / "a.exr.checkpoint") == checkpoint) << "it was removed or replaced";
    std::vector<std::string> stopped = slow;
    stopped.insert(stopped.end(), {"--seed", "1"});
    const Outcome unfinished = run(stopped);
    EXPECT_EQ(unfinished.exit_code, kDone);
    EXPECT_EQ(unfinished.err.find(line + ", so this one leaves none\n"), 0u) << unfinished.err;
    EXPECT_TRUE(text_of(folder / "a.exr.checkpoint") == checkpoint) << "it was removed or replaced";
}

TEST_F(OutputNames, StatisticsTakeNoNameOfACheckpoint)
{
    for (const char* name : {"a.exr.checkpoint", "./a.exr.checkpoint"}) {
        const Outcome o = run({"render", "triangle.obj", "-o", "a.exr", "--size", "8x4", "--spp", "1", "--stats", name});
        EXPECT_EQ(o.exit_code, kBadInput) << name;
        EXPECT_NE(o.err.find("or its checkpoint, cannot be written to one file"), std::string::npos) << o.err;
        EXPECT_FALSE(fs::exists(folder / "a.exr")) << "found before the picture is made";
    }
}

TEST_F(OutputNames, StatisticsReplaceNoFilesButStatistics)
{
    const std::vector<std::string> words{"render", "triangle.obj", "-o", "a.exr",   "--size",
                                         "8x4",    "--spp",        "1",  "--stats", "s.json"};
    for (const char* text : {R"({"name": "package"})", R"({"scene": 0, "asset": {}})", R"({"scenes": {}})", "{}",
                             "[] and more", R"([{"frame": "first"}])", R"([{"frames": 1}])", R"(["frame"])", "x"}) {
        std::ofstream(folder / "s.json") << text;
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << text;
        EXPECT_NE(o.err.find("s.json: is there already and holds no statistics"), std::string::npos) << o.err;
        EXPECT_EQ(text_of(folder / "s.json"), text);
    }
    for (const char* text : {"", "[]\n", " {\n \"scene\" : {\"nodes\": 1", "[\n{\"frame\": 12,"}) {
        std::ofstream(folder / "s.json") << text;
        EXPECT_EQ(run(words).exit_code, kDone) << text;
        EXPECT_TRUE(text_of(folder / "s.json").starts_with("{\n  \"scene\": {"));
    }
}

// A terminal obeys what follows an escape character, and files may be anybody's.
TEST_F(OutputNames, NamesInFilesAreShownAndNotObeyed)
{
    const std::string scene = "ev\033[31mil.obj";
    std::ofstream(folder / "a.mtl") << "newmtl red\033[31m\n";
    std::ofstream(folder / scene) << "mtllib a.mtl\nusemtl red\033[31m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                     "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    render::Image image(4, 4);
    for (const char* layer : {"beauty", "a\033[31m"}) image.add_layer(layer, {"R", "G", "B"}).pixels.assign(48, 0.5f);
    image.write(folder / "a.exr");
    const std::string ray = "origin 0.2 0.2 0.2, direction 1 0 0, footprint 0 0.001";
    const std::vector<std::vector<std::string>> calls{
        {"info", scene},
        {"verify", scene, "--subdivide", "on", "--rays", "1"},
        {"verify", scene, "--subdivide", "on", "--replay", ray},
        {"render", scene, "--subdivide", "on", "--size", "8x8", "--spp", "1", "--replay", "4,4"},
        {"compare", "a.exr", "a.exr", "--layer", "a\033[31m", "--max-error", "0"}};
    for (const std::vector<std::string>& words : calls) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << words[0] << ": " << o.err;
        EXPECT_EQ((o.out + o.err).find('\033'), std::string::npos) << words[0] << ": " << o.out << o.err;
        EXPECT_NE(o.out.find("\\x1b[31m"), std::string::npos) << words[0] << ": " << o.out;
    }
}

}  // namespace
}  // namespace occam
