// The executable as a person or a script meets it: exit codes, lines, files.
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
    for (const char* library : {"occam " OCCAM_PROJECT_VERSION "\n", "OpenSubdiv", "oneTBB", "OpenImageIO"})
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

// What is seen beside a triangle, and that it is lit.
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
        std::vector<std::string> arguments{"render", "-o", "a.png", "--size", "80x45", "--spp", "1", "--stats", "-"};
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
    EXPECT_EQ(with(o.err.substr(begin, o.err.find(' ', begin) - begin)).exit_code, kDone)
        << "what it asks for is enough: " << o.err;
}

// So short that nothing is finished, and so long that it never comes: neither depends on how fast the machine is.
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
    EXPECT_NE(late.err.find("out of time: 0 % of the picture"), std::string::npos) << late.err;
    const std::string stats = text_of(folder / "stats.json");
    EXPECT_NE(stats.find("\"complete\": false"), std::string::npos);
    EXPECT_NE(stats.find("out of time"), std::string::npos);
    const render::Image image = render::Image::read(folder / "a.exr");
    EXPECT_EQ(image.width, 64);
    EXPECT_EQ(image.height, 48);

    const auto pixels = [&] { return render::Image::read(folder / "a.exr").layer(0).pixels; };
    with("4", {});
    const std::vector<float> whole = pixels();
    EXPECT_EQ(with("4", {"--deadline", "1e6"}).err, "");
    EXPECT_EQ(pixels(), whole) << "a sample of each pixel comes first, and leaves no trace";
    EXPECT_NE(text_of(folder / "stats.json").find("\"complete\": true"), std::string::npos);
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "b.exr", "--deadline", "-1"}).exit_code, kBadInput);
}

TEST_F(Command, CompareChecksItsLimits)
{
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.exr", "--size", "32x32", "--spp", "1"}).exit_code, kDone);
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "b.exr", "--size", "32x32", "--spp", "4"}).exit_code, kDone);
    EXPECT_EQ(run({"compare", "a.exr", "a.exr", "--max-error", "0"}).exit_code, kDone);
    EXPECT_EQ(run({"compare", "a.exr", "b.exr"}).exit_code, kDone);
    const Outcome o = run({"compare", "a.exr", "b.exr", "--max-error", "1e-9", "--heat", "heat.png", "--json"});
    EXPECT_EQ(o.exit_code, kDoesNotHold);
    EXPECT_NE(o.err.find("max error"), std::string::npos);
    EXPECT_NE(o.out.find("\"rmse\""), std::string::npos);
    EXPECT_TRUE(fs::exists(folder / "heat.png"));
}

TEST_F(Command, InfoSaysWhatIsInAScene)
{
    const Outcome o = run({"info", "triangle.obj", "--json"});
    EXPECT_EQ(o.exit_code, kDone) << o.err;
    for (const char* key :
         {"\"nodes\"", "\"cages\"", "\"faces\": 1", "\"clips\"", "\"cameras\"", "\"lights\"", "\"bounds\"", "\"warnings\""})
        EXPECT_NE(o.out.find(key), std::string::npos) << key << o.out;
}

TEST_F(Command, AnInterruptWritesWhatIsDone)
{
    const pid_t child = start({"render", "triangle.obj", "-o", "a.png", "--size", "1024x1024", "--spp", "4096", "--progress",
                               "plain", "--threads", "1"});
    // Until the first line about tiles appears.
    for (int i = 0; i < 1000 && text_of(folder / "stderr.txt").find("rendering") == std::string::npos; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(child, SIGINT);
    const Outcome o = finish(child);
    EXPECT_EQ(o.exit_code, kInterrupted) << o.err;
    EXPECT_TRUE(fs::exists(folder / "a.png"));
}

}  // namespace
}  // namespace occam
