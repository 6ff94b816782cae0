// Tests of the executable as a person or a script uses it: exit codes, lines, files.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "render/compare.h"
#include "tests/support/command_test.h"
#include "tests/support/gltf_scene.h"

namespace occam {
namespace {

using namespace test;
using Command = CommandTest;

long lines_of(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

TEST_F(Command, HelpShowsAnExampleForEachCommand)
{
    for (const char* command : {"render", "animate", "info", "verify", "compare", "bench"}) {
        const Outcome o = run({command, "--help"});
        EXPECT_EQ(o.exit_code, kDone) << command;
        EXPECT_NE(o.out.find(std::string("Example: occam ") + command), std::string::npos) << o.out;
    }
}

TEST_F(Command, VersionNamesTheLibraries)
{
    const Outcome o = run({"--version"});
    EXPECT_EQ(o.exit_code, kDone);
    for (const char* library : {"occam " OCCAM_PROJECT_VERSION "\n", "OpenSubdiv", "OpenImageIO"})
        EXPECT_NE(o.out.find(library), std::string::npos) << library;
}

TEST_F(Command, BadUsageIsOneLineAndExitCode2)
{
    const std::vector<std::vector<std::string>> bad{{},
                                                    {"paint"},
                                                    {"render", "triangle.obj"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--spp", "0"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--size", "12"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--colour", "red"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--aov", "smell"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--shade", "face"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--crop", "1,0,0,1"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--look-at", "0,0,0,0,0,0"},
                                                    {"render", "triangle.obj", "-o", "a.png", "--camera", "none"},
                                                    {"render", "triangle.obj", "-o", "a.xyz"},
                                                    {"render", "missing.obj", "-o", "a.png"},
                                                    {"info", "missing.gltf"},
                                                    {"compare", "missing.exr", "missing.exr"}};
    for (const auto& arguments : bad) {
        const Outcome o = run(arguments);
        std::string line = "occam";
        for (const std::string& a : arguments) line += " " + a;
        EXPECT_EQ(o.exit_code, kBadInput) << line << '\n' << o.err;
        EXPECT_EQ(lines_of(o.err), 1) << line << '\n' << o.err;
        EXPECT_EQ(o.err.rfind("occam: ", 0), 0u) << o.err;
        EXPECT_FALSE(fs::exists(folder / "a.png")) << line;
    }
}

// The test checks what is visible beside a triangle, and that the triangle is lit.
TEST_F(Command, AnEnvironmentIsAnImageDaylightOrNone)
{
    const auto corner = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"render", "triangle.obj", "-o", "a.exr", "--size",
                                       "9x9",    "--spp",        "4",  "--exr", "float"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        const render::Image made = render::Image::read(folder / "a.exr");
        const std::vector<float>& pixels = made.find("beauty")->pixels;
        return std::pair(pixels[0], pixels[4 * 40]);
    };
    const auto [beside, on] = corner({"--environment", "none"});
    EXPECT_EQ(beside, 0);
    EXPECT_EQ(on, 0);
    const auto [sky, lit_by_sky] = corner({"--environment", "sky"});
    EXPECT_GT(sky, 0);
    EXPECT_GT(lit_by_sky, 0);
    const auto [brighter, lit_brighter] = corner({"--environment", "sky", "--environment-strength", "2"});
    EXPECT_FLOAT_EQ(brighter, 2 * sky);
    EXPECT_GT(lit_brighter, 1.2f * lit_by_sky);
    EXPECT_LT(lit_brighter, 1.9f * lit_by_sky) << "the lamp beside the sky stays as it is";

    render::Image image(4, 2);
    image.add_layer("beauty", {"R", "G", "B", "A"}).pixels.assign(32, 3);
    image.write(folder / "sky.exr", {.half = false});
    const auto [seen, lit] = corner({"--environment", "sky.exr", "--environment-strength", "0.5"});
    EXPECT_FLOAT_EQ(seen, 1.5f);
    EXPECT_GT(lit, 0.5f);
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "b.png", "--environment", "missing.exr"}).exit_code, kBadInput);
}

// Standard error is a file here, not a terminal.
TEST_F(Command, WarningsAreAlwaysPrintedTheFirstFiveAndACount)
{
    std::string text = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nmtllib a.mtl\nf 1 2 3\n";
    for (int i = 0; i < 8; ++i) text += "usemtl m" + std::to_string(i) + "\nt nonsense" + std::to_string(i) + "\nf 1 2 3\n";
    std::ofstream(folder / "many.obj") << text + "v 0 0 1\nf 1 2 3 4\nf 1 2 9\nf 1 1 2\np 1\ncurv 1\n";
    std::ofstream(folder / "a.mtl") << "newmtl m0\nmap_Kd none.png\nmap_Ks ../none.png\nmap_Ke ../none.png\n";
    const std::vector<std::string> words{"render", "many.obj", "-o", "a.png", "--size", "4x4", "--spp", "1"};
    const auto with = [&](const std::string& word) {
        std::vector<std::string> more = words;
        more.push_back(word);
        return run(more);
    };
    const auto count = [](const std::string& in, const std::string& what) {
        int found = 0;
        for (std::size_t at = 0; (at = in.find(what, at)) != std::string::npos; ++at) ++found;
        return found;
    };
    for (const Outcome& o : {run(words), with("-q")}) {
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        EXPECT_EQ(count(o.err, "occam: warning: "), 5) << o.err;
        EXPECT_EQ(count(o.err, "more warnings"), 1) << o.err;
        EXPECT_EQ(count(o.err, "faces are rendered as they are"), 1) << o.err;
    }
    std::vector<std::string> few = words;
    few.insert(few.end(), {"--filter", "mitchell"});
    EXPECT_EQ(count(run(few).err, "mitchell"), 1)
        << "what is amiss with the picture comes before what is amiss with the file";
    const Outcome all = with("-v");
    EXPECT_GT(count(all.err, "occam: warning: "), 5) << all.err;
    EXPECT_EQ(count(all.err, "more warnings"), 0) << all.err;
    const Outcome strict = with("--strict");
    EXPECT_EQ(strict.exit_code, kBadInput);
    EXPECT_EQ(lines_of(strict.err), 1) << strict.err;
}

TEST_F(Command, WhatIsNoImageIsAnErrorAndWhatIsMissingIsAWarning)
{
    std::ofstream(folder / "broken.png") << "\x89PNG nonsense";
    std::ofstream(folder / "a.mtl") << "newmtl a\nmap_Kd broken.png\nnewmtl b\nmap_Kd none.png\n";
    const std::string corners = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nmtllib a.mtl\n";
    std::ofstream(folder / "broken.obj") << corners + "usemtl a\nf 1 2 3\n";
    const auto render = [&](const std::string& scene, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"render", scene, "-o", "a.png", "--size", "4x4", "--spp", "1"};
        words.insert(words.end(), more.begin(), more.end());
        return run(words);
    };
    const Outcome broken = render("broken.obj");
    EXPECT_EQ(broken.exit_code, kBadInput);
    EXPECT_NE(broken.err.find("broken.obj: broken.png"), std::string::npos) << broken.err;
    const std::string path = (folder / "broken.obj").string();
    EXPECT_NE(render(path).err.find("occam: " + path + ": broken.png"), std::string::npos) << "as the user gave it";
    EXPECT_FALSE(fs::exists(folder / "a.png"));
    EXPECT_EQ(render("triangle.obj", {"--environment", "broken.png"}).exit_code, kBadInput);

    std::ofstream(folder / "a.mtl") << "newmtl a\nmap_Kd none.png\n";
    const Outcome missing = render("broken.obj");
    EXPECT_EQ(missing.exit_code, kDone) << missing.err;
    EXPECT_NE(missing.err.find("warning: image file is missing (none.png)"), std::string::npos) << missing.err;
    EXPECT_EQ(render("broken.obj", {"--strict"}).exit_code, kBadInput);
}

TEST_F(Command, BrokenJSONIsRefusedByLineAndColumn)
{
    std::ofstream(folder / "broken.gltf") << "{\"asset\":";
    const Outcome o = run({"info", "broken.gltf"});
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_NE(o.err.find("broken.gltf: not valid JSON: parse error at line 1, column 10"), std::string::npos) << o.err;
}

TEST_F(Command, AnOutputThatCannotBeWrittenIsExitCode3)
{
    const Outcome o = run({"render", "triangle.obj", "-o", "missing/a.png"});
    EXPECT_EQ(o.exit_code, kOutput);
    EXPECT_NE(o.err.find("missing/a.png"), std::string::npos) << o.err;
}

TEST_F(Command, RendersQuietlyAndWritesStatistics)
{
    const Outcome o = run(
        {"render", "triangle.obj", "-o", "a.exr", "--size", "64x48", "--spp", "4", "--aov", "depth,normal", "--stats", "-"});
    ASSERT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_EQ(o.err, "");
    for (const char* key : {"\"scene\"", "\"seconds\"", "\"rays\"", "\"per_second\"", "\"built\"", "\"by_level\"",
                            "\"memory\"", "\"flushes\"", "\"checksum\"", "\"settings\"", "\"version\"", "\"threads\""})
        EXPECT_NE(o.out.find(key), std::string::npos) << key;
    const render::Image image = render::Image::read(folder / "a.exr");
    EXPECT_EQ(image.width, 64);
    ASSERT_NE(image.find("depth"), nullptr);
    EXPECT_TRUE(std::isinf(image.find("depth")->pixels.front())) << "the corner is a miss";
    EXPECT_TRUE(std::isfinite(image.find("depth")->pixels[24 * 64 + 32])) << "the middle is the triangle";
}

TEST_F(Command, ThePictureDoesNotDependOnThreadsOrBudget)
{
    std::vector<std::string> sums;
    for (const auto& extra : {std::vector<std::string>{"--threads", "1"},
                              {"--threads", "2"},
                              {"--threads", "7"},
                              {"--threads", "7", "--share-tree", "3"},
                              {"--threads", "2", "--memory", "4M"}}) {
        std::vector<std::string> arguments{"render", "triangle.obj", "-o", "a.exr",   "--size",
                                           "90x50",  "--spp",        "4",  "--stats", "-"};
        arguments.insert(arguments.end(), extra.begin(), extra.end());
        const Outcome o = run(arguments);
        ASSERT_EQ(o.exit_code, kDone) << o.err;
        sums.push_back(o.out.substr(o.out.find("\"checksum\""), 32));
        EXPECT_EQ(sums.back(), sums.front()) << extra.back();
    }
}

TEST_F(Command, ShadesAtHitsUnlessToldToAtVertices)
{
    const auto stats = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments{"render", "-o", "a.png", "--size", "32x18", "--spp", "1", "--stats", "-"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome o = run(arguments);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        return o.out;
    };
    const std::string usual = stats({}), at_hits = stats({"--shade", "hit"}), at_vertices = stats({"--shade", "vertex"});
    for (const std::string& out : {usual, at_hits}) {
        EXPECT_NE(out.find("\"shade\": \"hit\""), std::string::npos);
        EXPECT_NE(out.find("\"vertices_looked_up\": 0,"), std::string::npos);
    }
    EXPECT_NE(at_vertices.find("\"shade\": \"vertex\""), std::string::npos);
    EXPECT_EQ(at_vertices.find("\"vertices_looked_up\": 0,"), std::string::npos);
}

TEST_F(Command, AMemoryBudgetBelowTheFloorIsRefusedAndTheFloorIsNamed)
{
    const std::vector<std::string> words{"render", "triangle.obj", "-o", "a.exr",   "--size", "64x64", "--spp",
                                         "1",      "--threads",    "1",  "--memory"};
    const auto with = [&](const std::string& memory) {
        std::vector<std::string> all = words;
        all.push_back(memory);
        return run(all);
    };
    const Outcome o = with("1K");
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_FALSE(fs::exists(folder / "a.exr"));
    const std::string before = "needs a memory budget of ";
    const std::size_t at = o.err.find(before);
    ASSERT_NE(at, std::string::npos) << o.err;
    const std::size_t begin = at + before.size();
    EXPECT_NE(o.err.find("(1K given)"), std::string::npos) << o.err;
    EXPECT_NE(with("1").err.find("(1 byte given)"), std::string::npos);
    EXPECT_NE(with("1000").err.find("(1000 bytes given)"), std::string::npos);
    EXPECT_EQ(with(o.err.substr(begin, o.err.find(' ', begin) - begin)).exit_code, kDone)
        << "what it asks for is enough: " << o.err;
}

// One time limit is so short that nothing is finished, and the other so long that it is never reached, so neither depends on
// the speed of the machine.
TEST_F(Command, ADeadlineEndsTheFrameWithWhatThereIs)
{
    const auto with = [&](const std::string& spp, const std::vector<std::string>& more) {
        std::vector<std::string> all{"render", "triangle.obj", "-o", "a.exr",   "--size",
                                     "64x48",  "--spp",        spp,  "--stats", "stats.json"};
        all.insert(all.end(), more.begin(), more.end());
        const Outcome o = run(all);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        return o;
    };
    const Outcome late = with("65536", {"--deadline", "1e-9", "-v"});
    EXPECT_NE(late.err.find("out of time: some pixels have no sample and are black"), std::string::npos) << late.err;
    const std::string stats = text_of(folder / "stats.json");
    EXPECT_NE(stats.find("\"complete\": false"), std::string::npos);
    EXPECT_NE(stats.find("out of time"), std::string::npos);
    const render::Image image = render::Image::read(folder / "a.exr");
    EXPECT_EQ(image.width, 64);
    EXPECT_EQ(image.height, 48);

    const auto pixels = [&] { return render::Image::read(folder / "a.exr").layer(0).pixels; };
    EXPECT_TRUE(fs::remove(folder / "a.exr.checkpoint")) << "it would outlast pictures of fewer samples";
    with("4", {});
    const std::vector<float> whole = pixels();
    EXPECT_EQ(with("4", {"--deadline", "1e6"}).err, "");
    EXPECT_EQ(pixels(), whole) << "samples made in rounds leave no trace";
    EXPECT_NE(text_of(folder / "stats.json").find("\"complete\": true"), std::string::npos);
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "b.exr", "--deadline", "-1"}).exit_code, kBadInput);
}

TEST_F(Command, AMomentOfASceneThatDoesNotMoveIsAWarning)
{
    const Outcome o = run({"render", "triangle.obj", "-o", "a.exr", "--size", "16x16", "--spp", "1", "--frame", "3"});
    EXPECT_EQ(o.exit_code, kDone);
    EXPECT_EQ(o.err, "occam: warning: nothing in the scene is animated, so --time and --frame change nothing\n");
    const std::vector<std::string> sequence = {"animate", "triangle.obj", "-o",    "a.#.exr", "--frames",
                                               "0-1",     "--size",       "16x16", "--spp",   "1"};
    EXPECT_EQ(run(sequence).err, "occam: warning: nothing in the scene is animated, so all frames are alike\n");
    std::vector<std::string> strict = sequence;
    strict.insert(strict.end(), {"--strict", "--overwrite"});
    EXPECT_EQ(run(strict).exit_code, kBadInput);
}

TEST_F(Command, AnErrorOfZeroEndsNoPixelEarly)
{
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.exr", "--size", "16x16", "--spp", "4", "--error", "0"}).exit_code,
              kDone);
}

TEST_F(Command, InfoSaysWhatIsInAScene)
{
    const Outcome o = run({"info", "triangle.obj", "--json"});
    EXPECT_EQ(o.exit_code, kDone) << o.err;
    for (const char* key :
         {"\"nodes\"", "\"cages\"", "\"faces\": 1", "\"clips\"", "\"cameras\"", "\"lights\"", "\"bounds\"", "\"warnings\""})
        EXPECT_NE(o.out.find(key), std::string::npos) << key << o.out;
}

// The file has two squares, each moved out of the picture by a clip of its own.
TEST_F(Command, ClipsOfDifferentObjectsPlayTogetherAndOneCanBeChosen)
{
    test::Gltf g = test::square();
    g.nodes = R"({"mesh": 0}, {"mesh": 0, "translation": [2, 0, 0]})";
    g.put<float>({0, 1});
    g.put<float>({0, 0, 0, 0, 900, 0});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"})");
    const auto clip = [](const char* name, int node) {
        return std::string(R"({"name": ")") + name + R"(", "samplers": [{"input": 2, "output": 3}],
            "channels": [{"sampler": 0, "target": {"path": "translation", "node": )" +
               std::to_string(node) + "}}]}";
    };
    g.more = R"(, "animations": [)" + clip("left", 0) + ", " + clip("right", 1) + "]";
    std::ofstream(folder / "two.gltf") << g.json();
    std::ofstream(folder / "data file.bin", std::ios::binary) << g.bin;
    const auto coverage = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{
            "render", "two.gltf",     "-o",  "a.exr",    "--size", "12x6",      "--spp",
            "1",      "--background", "off", "--jitter", "off",    "--look-at", "1.5,0.5,5,1.5,0.5,0"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        const render::Image made = render::Image::read(folder / "a.exr");
        int left = 0, right = 0;
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 12; ++x)
                (x < 6 ? left : right) += made.find("beauty")->pixels[std::size_t(4 * (12 * y + x) + 3)] > 0;
        return std::pair(left > 0, right > 0);
    };
    EXPECT_EQ(coverage({}), std::pair(true, true));
    EXPECT_EQ(coverage({"--time", "1"}), std::pair(false, false));
    EXPECT_EQ(coverage({"--time", "1", "--clip", "all"}), std::pair(false, false));
    EXPECT_EQ(coverage({"--time", "1", "--clip", "left"}), std::pair(false, true));
    EXPECT_EQ(coverage({"--time", "1", "--clip", "1"}), std::pair(true, false));
    const Outcome info = run({"info", "two.gltf", "--json"});
    EXPECT_NE(info.out.find("\"clips_together\""), std::string::npos);
}

TEST_F(Command, AnInterruptWritesWhatIsDone)
{
    const pid_t child = start({"render", "triangle.obj", "-o", "a.png", "--size", "512x512", "--spp", "256", "--progress",
                               "plain", "--threads", "1"});
    // This waits until the first tiles are finished.
    for (int i = 0; i < 3000 && !has_begun(text_of(folder / "stderr.txt")); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(child, SIGINT);
    const Outcome o = finish(child);
    EXPECT_EQ(o.exit_code, kInterrupted) << o.err;
    EXPECT_TRUE(fs::exists(folder / "a.png"));
}

// The first tile takes seconds.
TEST_F(Command, AnInterruptBeforeAnythingIsDoneKeepsTheOlderPicture)
{
    std::ofstream(folder / "a.png") << "an older picture";
    const pid_t child = start({"render", "triangle.obj", "-o", "a.png", "--size", "1024x1024", "--spp", "65536",
                               "--progress", "plain", "--threads", "1"});
    for (int i = 0; i < 3000 && text_of(folder / "stderr.txt").find("rendering") == std::string::npos; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    kill(child, SIGINT);
    const Outcome o = finish(child);
    EXPECT_EQ(o.exit_code, kInterrupted) << o.err;
    EXPECT_TRUE(text_of(folder / "a.png") == "an older picture") << "it was replaced by a black one";
}

}  // namespace
}  // namespace occam
