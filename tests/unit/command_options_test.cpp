// Tests of options that a person or a script gives without effect, without a value, or out of range.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>

#include "occam/occam.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class CommandOptions : public CommandTest {};

constexpr char kRay[] = "origin 0.2 0.2 0.2, direction 1 0 0, footprint 0 0.001";

const std::vector<std::vector<std::string>> kIdle{
    {"render", "triangle.obj", "-o", "a.png", "--view", "depth", "--exposure", "2"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "depth", "--tonemap", "aces"},
    {"render", "triangle.obj", "-o", "a.png", "--aov", "depth"},
    {"render", "triangle.obj", "-o", "a.jpg", "--exr", "float"},
    {"render", "triangle.obj", "-o", "a.exr", "--tonemap", "srgb"},
    {"render", "triangle.obj", "-o", "a.hdr", "--exposure", "1"},
    {"render", "triangle.obj", "-o", "a.png", "--ao-distance", "3"},
    {"render", "triangle.obj", "-o", "a.png", "--integrator", "ao", "--bounces", "3"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "depth", "--integrator", "ao"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "face", "--bounces", "3"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "tests", "--clamp", "1"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "uv", "--light-samples", "2"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "uv", "--background", "off"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "depth", "--environment", "sky"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "depth", "--environment-strength", "2"},
    {"render", "triangle.obj", "-o", "a.png", "--integrator", "ao", "--environment", "none"},
    {"render", "triangle.obj", "-o", "a.png", "--integrator", "ao", "--environment-strength", "2"},
    {"render", "triangle.obj", "-o", "a.png", "--frame", "1", "--shutter", "0,0", "--shutter-segments", "4"},
    {"verify", "tetrahedron.obj", "--subdivide", "on", "--replay", kRay, "--json"},
    {"verify", "tetrahedron.obj", "--subdivide", "on", "--replay", kRay, "--rays", "10"},
    {"render", "triangle.obj", "-o", "a.png", "--error", "0.1"},
    {"render", "triangle.obj", "-o", "a.png", "--error", "0.1", "--spp", "32", "--min-spp", "32"},
    {"render", "triangle.obj", "-o", "a.png", "--min-spp", "4"},
    {"render", "triangle.obj", "-o", "a.png", "--error", "0", "--min-spp", "4"},
    {"render", "triangle.obj", "-o", "a.png", "--environment", "none", "--environment-strength", "2"},
    {"render", "triangle.obj", "-o", "a.png", "--environment", "sky", "--environment-rotation", "20"},
    {"render", "triangle.obj", "-o", "a.png", "--blades", "5"},
    {"render", "triangle.obj", "-o", "a.png", "--fps", "30"},
    {"render", "-o", "a.png", "--subdivide", "on"},
    {"info", "--subdivide", "on"},
    {"info", "--variant", "red"},
    {"info", "--json", "--strict"},
    {"verify", "--strict", "--rays", "1"},
    {"render", "triangle.obj", "-o", "a.png", "--quality", "high", "--spp", "2", "--shading-rate", "1"},
    {"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0", "-q", "--progress", "plain"},
    {"render", "triangle.obj", "-o", "a.png", "--view", "level", "--lod", "frozen"},
    {"bench", "--list", "--only", "fast"},
    {"bench", "--list", "crowd"},
    {"bench", "--list", "--json", "a.json"},
    {"render", "triangle.obj", "-o", "a.exr", "--replay", "3,3", "--stats", "a.json"},
    {"render", "triangle.obj", "-o", "a.exr", "--replay", "3,3", "--checkpoint", "on"},
    {"render", "triangle.obj", "-o", "a.exr", "--replay", "3,3", "--deadline", "1"},
    {"render", "triangle.obj", "-o", "a.exr", "--replay", "3,3", "--resume"},
    {"render", "triangle.obj", "--replay", "3,3", "--aov", "depth"},
    {"render", "triangle.obj", "--replay", "3,3", "--exr", "float"},
    {"render", "triangle.obj", "--replay", "3,3", "--exposure", "1"},
    {"render", "triangle.obj", "--replay", "3,3", "--tonemap", "srgb"},
    {"render", "triangle.obj", "-o", "a.exr", "--jitter", "off", "--filter", "gaussian"},
    {"render", "triangle.obj", "-o", "a.exr", "--jitter", "off", "--filter-radius", "3"},
    {"render", "triangle.obj", "-o", "a.exr", "--lens", "0.1", "--focus", "2", "--blades", "1"},
    {"render", "triangle.obj", "-o", "a.exr", "--lens", "0.1", "--focus", "2", "--blades", "2"},
    {"compare", "a.exr", "a.exr", "--layer", "beauty"},
    {"compare", "a.exr", "a.exr", "--json", "--layer", "beauty"},
    {"compare", "a.exr", "a.exr", "--layer", "smell", "--max-mse", "1"},
    {"compare", "a.exr", "a.exr", "--heat-scale", "2"},
    {"verify", "triangle.obj", "--rays", "100"}};

TEST_F(CommandOptions, OptionsThatWouldDoNothingAreRefused)
{
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.exr", "--size", "8x8"}).exit_code, kDone);
    std::ofstream(folder / "tetrahedron.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    EXPECT_EQ(run({"verify", "tetrahedron.obj", "--subdivide", "on", "--replay", kRay}).exit_code, kDone);
    for (const auto& arguments : kIdle) {
        const Outcome o = run(arguments);
        EXPECT_EQ(o.exit_code, kBadInput) << arguments[arguments.size() - 2] << o.err;
        EXPECT_EQ(std::ranges::count(o.err, '\n'), 1) << o.err;
    }
}

TEST_F(CommandOptions, OptionsThatLeaveSomethingToOthersAreTaken)
{
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"--quality", "fast", "--spp", "1"},
                                               {"--quality", "fast", "--shading-rate", "2"},
                                               {"--threads", "1", "--share-tree", "2"},
                                               {"--integrator", "ao", "--lod", "frozen"},
                                               {"--bounces", "0", "--clamp", "1"}}) {
        std::vector<std::string> all{"render", "triangle.obj", "-o", "b.exr", "--size", "8x8"};
        all.insert(all.end(), words.begin(), words.end());
        EXPECT_EQ(run(all).exit_code, kDone) << words[0] << words[2];
    }
    EXPECT_EQ(run({"compare", "b.exr", "b.exr", "--layer", "beauty", "--heat", "heat.png"}).exit_code, kDone);
}

// A script whose variable is empty would otherwise get another camera, clip or file than it asks for.
TEST_F(CommandOptions, OptionsWithAnEmptyValueAreRefused)
{
    std::vector<std::vector<std::string>> calls{{"compare", "a.exr", "a.exr", "--heat", ""},
                                                {"verify", "a.obj", "--replay", ""}};
    for (const char* option : {"--camera", "--lod-camera", "--clip", "--environment", "--stats", "--variant", "--view"})
        calls.push_back({"render", "triangle.obj", "-o", "a.png", option, ""});
    for (const std::vector<std::string>& call : calls) {
        const Outcome o = run(call);
        const std::string& option = call[call.size() - 2];
        EXPECT_EQ(o.exit_code, kBadInput) << option;
        EXPECT_NE(o.err.find(option), std::string::npos) << o.err;
        EXPECT_EQ(std::ranges::count(o.err, '\n'), 1) << o.err;
    }
}

TEST_F(CommandOptions, CountsAreWholeNumbersWithinTheirLimits)
{
    for (const char* bad : {"-4", "0", "1.5", "1e99", "nan", "x", ""})
        EXPECT_EQ(run({"verify", "triangle.obj", "--rays", bad}).exit_code, kBadInput) << bad;
    for (const char* option : {"--seed", "--threads", "--deadline", "--error", "--filter-radius", "--bounces"})
        EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.png", option, "-1"}).exit_code, kBadInput) << option;
    EXPECT_FALSE(fs::exists(folder / "a.png"));
    const Outcome o = run({"render", "triangle.obj", "-o", "a.png", "--size", "8x8", "--spp", "1e1", "--seed",
                           "18446744073709551615", "--stats", "-"});
    EXPECT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_NE(o.out.find("\"spp\": 10,"), std::string::npos);
    EXPECT_NE(o.out.find("\"seed\": 18446744073709551615"), std::string::npos);
}

TEST_F(CommandOptions, AMomentOfAStillSceneIsAWarningAndAnErrorIfItIsStrict)
{
    const std::string what = "nothing in the scene is animated, so --time and --frame change nothing\n";
    std::ofstream(folder / "tetrahedron.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    const std::vector<std::vector<std::string>> calls{
        {"render", "tetrahedron.obj", "-o", "a.png", "--size", "8x4", "--spp", "1", "--frame", "3", "--subdivide", "on"},
        {"verify", "tetrahedron.obj", "--rays", "1", "--time", "3", "--subdivide", "on"}};
    for (std::vector<std::string> words : calls) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        EXPECT_NE(o.err.find("occam: warning: " + what), std::string::npos) << words[0] << ": " << o.err;
        words.push_back("--strict");
        const Outcome strict = run(words);
        EXPECT_EQ(strict.exit_code, kBadInput) << words[0];
        EXPECT_NE(strict.err.find("occam: tetrahedron.obj: " + what), std::string::npos) << strict.err;
    }
}

// A rotation shows on an image alone, and a factor of brightness also on the daylight that a scene without lamps gets.
TEST_F(CommandOptions, AnEnvironmentThatIsNotThereIsNeitherTurnedNorMadeBrighterWithoutAWord)
{
    std::ofstream(folder / "lamp.gltf") << R"({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
"scene": 0, "scenes": [{"nodes": [0]}], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}},
"nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]})";
    const auto outcome_of = [&](const std::string& scene, std::vector<std::string> words) {
        words.insert(words.begin(), {"render", scene, "-o", "a.png", "--size", "8x4", "--spp", "1"});
        return run(words);
    };
    const std::string turned = "no image is around the scene, so --environment-rotation changes nothing\n",
                      brighter =
                          "neither an image nor daylight is around the scene, so --environment-strength changes nothing\n";
    for (const char* scene : {"triangle.obj", "lamp.gltf"}) {
        const Outcome o = outcome_of(scene, {"--environment-rotation", "90"});
        EXPECT_EQ(o.exit_code, kDone) << scene;
        EXPECT_NE(o.err.find("occam: warning: " + turned), std::string::npos) << scene << ": " << o.err;
        const Outcome strict = outcome_of(scene, {"--environment-rotation", "90", "--strict"});
        EXPECT_EQ(strict.exit_code, kBadInput) << scene;
        EXPECT_NE(strict.err.find(turned), std::string::npos) << scene << ": " << strict.err;
    }
    for (const char* factor : {"0", "5"}) {
        const Outcome o = outcome_of("lamp.gltf", {"--environment-strength", factor});
        EXPECT_EQ(o.exit_code, kDone) << factor;
        EXPECT_NE(o.err.find("occam: warning: " + brighter), std::string::npos) << factor << ": " << o.err;
        EXPECT_EQ(outcome_of("triangle.obj", {"--environment-strength", factor}).err.find(brighter), std::string::npos);
        EXPECT_EQ(outcome_of("lamp.gltf", {"--environment", "sky", "--environment-strength", factor}).err.find(brighter),
                  std::string::npos);
    }
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "sky.hdr", "--size", "8x4", "--spp", "1"}).exit_code, kDone);
    const Outcome image = outcome_of("lamp.gltf", {"--environment", "sky.hdr", "--environment-rotation", "90",
                                                   "--environment-strength", "5", "--strict"});
    EXPECT_EQ(image.exit_code, kDone) << image.err;
    EXPECT_EQ(image.err.find("changes nothing"), std::string::npos) << image.err;
}

// Such a filter moves samples, and there is nothing to move.
TEST_F(CommandOptions, AFilterOfBothSignsIsNoConcernWithoutJitter)
{
    Scene scene;
    Settings settings{.width = 8, .height = 8, .spp = 1, .jitter = false, .filter = render::FilterKind::Mitchell};
    Renderer renderer;
    for (const bool jitter : {false, true}) {
        settings.jitter = jitter;
        renderer.render(scene, Camera::framing({}), settings);
        EXPECT_EQ(renderer.stats().warnings.size(), jitter ? 1u : 0u);
    }
}

TEST_F(CommandOptions, ErrorsNameTheBuiltInScene)
{
    for (const auto& [option, value] : {std::pair("--clip", "all"), std::pair("--lod-camera", "foo")}) {
        const Outcome o = run({"render", "-o", "a.png", "--size", "8x4", "--spp", "1", option, value});
        EXPECT_EQ(o.exit_code, kBadInput) << option;
        EXPECT_EQ(o.err.find("occam: the built-in scene: has no "), 0u) << o.err;
    }
}

// A batch system may leave a process fewer processors than the machine has.
TEST_F(CommandOptions, WorkersAreAsManyAsTheProcessorsOfTheProcess)
{
    before_exec = [] {
        cpu_set_t allowed;
        if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
        int first = 0;
        while (first < CPU_SETSIZE - 1 && !CPU_ISSET(first, &allowed)) ++first;
        cpu_set_t one;
        CPU_ZERO(&one);
        CPU_SET(first, &one);
        sched_setaffinity(0, sizeof one, &one);
    };
    const Outcome o = run({"render", "triangle.obj", "-o", "a.png", "--size", "8x4", "--spp", "1", "--stats", "-"});
    EXPECT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_NE(o.out.find("\"threads\": 1,"), std::string::npos) << o.out;
}

}  // namespace
}  // namespace occam
