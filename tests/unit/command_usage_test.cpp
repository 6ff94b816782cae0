// What the command says to a line that it cannot parse.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;
using CommandUsage = CommandTest;

TEST_F(CommandUsage, AMistakeIsOneLineThatSaysWhatToDo)
{
    const auto expect = [&](const std::vector<std::string>& words, const std::string& line) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput);
        EXPECT_EQ(o.err, "occam: " + line + "\n");
    };
    expect({}, "a command is needed: render, animate, info, verify, compare, texture or bench (occam --help)");
    expect({"--hlep"}, "there is no option '--hlep' (occam --help)");
    expect({"triangle.obj"},
           "there is no command 'triangle.obj'; to render it: occam render triangle.obj -o triangle.png "
           "(occam --help)");
    expect({"rendr", "triangle.obj"}, "there is no command 'rendr' (occam --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--sp", "4"},
           "there is no option '--sp'; there is --spp (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--colour=4"}, "there is no option '--colour' (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--rate", "4"},
           "there is no option '--rate'; there is --shading-rate (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--frame"}, "--frame needs a value (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--frame", "1.5"},
           "--frame: expected a whole number from -1000000000 to 1000000000, not '1.5' (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--spp", "1", "--spp", "2"},
           "--spp is given more than once (occam render --help)");
    expect({"render", "triangle.obj"}, "--output is required (occam render --help)");
    expect({"render", "triangle.obj", "-o", "a.png", "--size", "65537x1"},
           "expected from 1 to 65536 pixels a side, not 65537x1 (size)");
    expect({"animate", "triangle.obj", "-o", "a.#.png", "--frames", "999999-1000001"},
           "--frames: expected frames from 0 to 1000000 like 1-240, 1-240x10 or 1,5,9, not '999999-1000001' "
           "(occam animate --help)");
}

// The parser takes the next word for the value, so a script with an empty variable would get another scene, clip or file.
TEST_F(CommandUsage, AnOptionWithNothingBehindItsSignTakesNoOtherWord)
{
    const std::vector<std::vector<std::string>> calls{{"info", "--variant=", "triangle.obj"},
                                                      {"render", "triangle.obj", "--clip=", "Swim", "-o", "a.png"},
                                                      {"render", "triangle.obj", "--output=", "a.png"},
                                                      {"render", "triangle.obj", "-o", "a.png", "--spp=", "4"},
                                                      {"compare", "a.exr", "b.exr", "--max-rmse=", "1"},
                                                      {"info", "triangle.obj", "--json="}};
    for (const std::vector<std::string>& words : calls) {
        const Outcome o = run(words);
        const auto empty = std::find_if(words.begin(), words.end(), [](const std::string& w) { return w.ends_with('='); });
        EXPECT_EQ(o.exit_code, kBadInput) << *empty;
        EXPECT_EQ(o.err, "occam: " + empty->substr(0, empty->size() - 1) + ": its value is empty (occam " + words[0] +
                             " --help)\n");
    }
    fs::copy_file(folder / "triangle.obj", folder / "--scene=");
    const Outcome file = run({"info", "--", "--scene="});
    EXPECT_EQ(file.err.find("its value is empty"), std::string::npos) << "a name after -- is no option: " << file.err;
    EXPECT_EQ(run({"render", "-o", "a.png", "--size=8x4", "--spp", "1", "--", "triangle.obj"}).exit_code, kDone);
}

// The parser takes the first part alone, prints the version or the help, and the rest is lost.
TEST_F(CommandUsage, AFlagTakesNoValue)
{
    const auto expect = [&](const std::vector<std::string>& words, const std::string& line) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << line << o.out;
        EXPECT_EQ(o.err, "occam: " + line + "\n");
    };
    expect({"--version=1"}, "--version takes no value (occam --help)");
    expect({"--help=no"}, "--help takes no value (occam --help)");
    expect({"-h2"}, "there is no option '-h2' (occam --help)");
    expect({"render", "-h2"}, "there is no option '-h2' (occam render --help)");
    expect({"render", "--help=spp"}, "--help takes no value (occam render --help)");
    expect({"render", "-qx", "-o", "a.png"}, "there is no option '-qx' (occam render --help)");
    expect({"info", "triangle.obj", "--json=false"}, "--json takes no value (occam info --help)");
    expect({"info", "triangle.obj", "--strict=true"}, "--strict takes no value (occam info --help)");
    EXPECT_EQ(run({"render", "triangle.obj", "-qvo", "-h2.png", "--size", "8x4", "--spp", "1"}).exit_code, kDone)
        << "a value may begin with a dash";
    EXPECT_TRUE(fs::exists(folder / "-h2.png"));
    EXPECT_EQ(run({"render", "-o", "a.png", "--size", "8x4", "--spp", "1", "--", "-h2.obj"}).err,
              "occam: -h2.obj: no such file\n");
}

TEST_F(CommandUsage, APartThatSlurmDoesNotStateIsTold)
{
    before_exec = [] { setenv("SLURM_ARRAY_TASK_ID", "5", 1); };  // but not of how many tasks
    const Outcome o = run({"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0-1", "--size", "4x4", "--spp", "1"});
    EXPECT_EQ(o.exit_code, kDone);
    EXPECT_EQ(o.err.find("occam: Slurm's array variables do not say which part of the sequence is this task's"), 0u)
        << o.err;
    EXPECT_TRUE(fs::exists(folder / "a.0.png"));
    EXPECT_TRUE(fs::exists(folder / "a.1.png"));
}

TEST_F(CommandUsage, WhatIsOutOfRangeIsNamed)
{
    const auto expect = [&](const char* command, const char* option, const std::string& value) {
        std::vector<std::string> words{command, "triangle.obj", "-o", "a.#.png", option, value};
        if (command == std::string("animate") && option != std::string("--frames"))
            words.insert(words.end(), {"--frames", "0"});
        if (command == std::string("compare")) words = {command, "a.exr", "a.exr", option, value};
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << option;
        EXPECT_EQ(o.err.find(std::string("occam: ") + option + ": expected "), 0u) << o.err;
        EXPECT_NE(o.err.find(", not '" + value + "' (occam " + command + " --help)\n"), std::string::npos) << o.err;
    };
    for (const auto& [option, value] : std::vector<std::pair<const char*, const char*>>{{"--filter-radius", "16.1"},
                                                                                        {"--error", "1"},
                                                                                        {"--deadline", "-1"},
                                                                                        {"--shading-rate", "1e6"},
                                                                                        {"--ao-distance", "-2"},
                                                                                        {"--fov", "180"},
                                                                                        {"--lens", "0"},
                                                                                        {"--focus", "-3"},
                                                                                        {"--blades", "2"},
                                                                                        {"--fps", "0"},
                                                                                        {"--clamp", "-1"},
                                                                                        {"--environment-strength", "-1"},
                                                                                        {"--environment-rotation", "x"},
                                                                                        {"--shutter", "1,0"},
                                                                                        {"--shutter", "0,1e9"},
                                                                                        {"--spp", "0"},
                                                                                        {"--quality", "low"},
                                                                                        {"--view", "smell"},
                                                                                        {"--exposure", "101"},
                                                                                        {"--size", "0x4"},
                                                                                        {"--threads", "0"},
                                                                                        {"--memory", "-1"}})
        for (const char* command : {"render", "animate"}) expect(command, option, value);
    expect("render", "--replay", "1");
    expect("animate", "--frames", "5-1");
    for (const char* option : {"--heat-scale", "--max-rmse", "--min-psnr"}) expect("compare", option, "-1");
    EXPECT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--frame", "1", "--shutter", "0,1", "--shutter-segments", "3"})
                  .err.find("occam: --shutter-segments: expected 1, 2, 4, 8, 16 or 32, not '3'"),
              0u);
}

TEST_F(CommandUsage, NumbersBeyondTheRangeOfFloatsAreRefusedByTheirOption)
{
    for (const char* option : {"--fov", "--clamp", "--ao-distance", "--deadline", "--environment-strength", "--frame"}) {
        const Outcome o = run({"render", "triangle.obj", "-o", "a.exr", option, "1e300"});
        EXPECT_EQ(o.exit_code, kBadInput) << option;
        EXPECT_EQ(o.err.find(std::string("occam: ") + option + ": expected "), 0u) << o.err;
    }
    const Outcome o = run({"render", "triangle.obj", "-o", "a.exr", "--look-at", "1e300,0,0,0,0,0"});
    EXPECT_EQ(o.err.find("occam: --look-at: expected "), 0u) << o.err;
    for (const char* stops : {"-3e38", "101"})
        EXPECT_EQ(
            run({"render", "triangle.obj", "-o", "a.png", "--exposure", stops}).err.find("occam: --exposure: expected "),
            0u);
}

}  // namespace
}  // namespace occam
