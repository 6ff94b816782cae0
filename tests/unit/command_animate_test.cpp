// Tests of `occam animate` as a render farm uses it: stopped at any moment and started again, in parts, and without space to
// write.
#include <OpenImageIO/imageio.h>
#include <linux/capability.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <set>
#include <thread>

#include "render/image.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

// Describes a triangle that slides and turns for one second. Translation and rotation are interpolated linearly.
constexpr const char* kMovingTriangle = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"animations": [{"name": "slide", "samplers": [{"input": 1, "output": 2}],
  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]},
               {"name": "rise", "samplers": [{"input": 1, "output": 3}],
  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
"buffers": [{"uri": "moving.bin", "byteLength": 92}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
{"buffer": 0, "byteOffset": 44, "byteLength": 48}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
{"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
{"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
{"bufferView": 2, "byteOffset": 24, "componentType": 5126, "count": 2, "type": "VEC3"}]})";

class Animate : public CommandTest {
protected:
    void SetUp() override
    {
        CommandTest::SetUp();
        const float numbers[] = {-1, -1,           0, 1, -1, 0, 0, 1, 0, /* times */ 0, 1, /* slide */ 0, 0, 0, 2, 0,
                                 0,  /* rise */ 0, 0, 0, 0,  2, 0};
        std::ofstream(folder / "moving.bin", std::ios::binary).write(reinterpret_cast<const char*>(numbers), sizeof numbers);
        std::ofstream(folder / "moving.gltf") << kMovingTriangle;
    }
    std::vector<std::string> words(const std::string& pattern, const std::string& frames,
                                   const std::vector<std::string>& more = {}, const std::string& spp = "4",
                                   const std::string& fps = "10") const
    {
        std::vector<std::string> all{"animate", "moving.gltf", "-o",     pattern, "--frames", frames,
                                     "--fps",   fps,           "--size", "48x32", "--spp",    spp};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::string bytes(const std::string& name) const { return text_of(folder / name); }
    std::vector<float> pixels(const std::string& name) const { return render::Image::read(folder / name).layer(0).pixels; }
};

TEST_F(Animate, AFrameIsTheOneThatRenderMakes)
{
    ASSERT_EQ(run(words("a.####.exr", "0-4x2", {"--clip", "rise"})).exit_code, kDone);
    ASSERT_EQ(run({"render", "moving.gltf", "-o", "one.exr", "--frame", "4", "--clip", "rise", "--fps", "10", "--size",
                   "48x32", "--spp", "4"})
                  .exit_code,
              kDone);
    ASSERT_EQ(
        run({"render", "moving.gltf", "-o", "time.exr", "--time", "0.4", "--clip", "1", "--size", "48x32", "--spp", "4"})
            .exit_code,
        kDone);
    EXPECT_EQ(pixels("a.0004.exr"), pixels("one.exr"));
    EXPECT_EQ(pixels("a.0004.exr"), pixels("time.exr"));
    EXPECT_NE(pixels("a.0004.exr"), pixels("a.0000.exr"));
    EXPECT_FALSE(fs::exists(folder / "a.0001.exr"));
    const Outcome o = run({"render", "moving.gltf", "-o", "b.exr", "--clip", "fly"});
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_NE(o.err.find("slide, rise"), std::string::npos) << o.err;
}

TEST_F(Animate, AShutterOfOneMomentIsTheStillPictureOfThatMoment)
{
    const auto render = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> all{"render", "moving.gltf", "-o",    name,    "--clip",
                                     "slide",  "--size",      "48x32", "--spp", "4"};
        all.insert(all.end(), more.begin(), more.end());
        EXPECT_EQ(run(all).exit_code, kDone) << name;
        return pixels(name);
    };
    const auto still = render("still.exr", {"--time", "0.5"});
    EXPECT_EQ(render("moment.exr", {"--time", "0.25", "--fps", "10", "--shutter", "2.5,2.5"}), still);
    EXPECT_EQ(render("closed.exr", {"--time", "0.5", "--fps", "10", "--shutter", "0,0"}), still);
    EXPECT_NE(render("none.exr", {"--time", "0.25"}), still);
    // Beyond its end, a clip holds its last pose.
    EXPECT_EQ(render("beyond.exr", {"--time", "2", "--shutter", "0,3"}), render("end.exr", {"--time", "1"}));
    EXPECT_EQ(render("long.exr", {"--time", "2", "--shutter", "-1e6,-5e5"}), render("start.exr", {"--time", "0"}));
}

TEST_F(Animate, AShutterBlursFramesAndIsTold)
{
    const std::vector<std::string> options{"--clip", "slide", "--shutter", "-0.5,0.5", "--aov", "motion", "--stats", "-"};
    const Outcome o = run(words("a.####.exr", "5", options));
    ASSERT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_NE(o.out.find("\"segments\": 1,"), std::string::npos) << "a straight path at constant speed: " << o.out;
    EXPECT_NE(o.out.find("\"shutter\": ["), std::string::npos);
    const auto picture = OIIO::ImageInput::open((folder / "a.0005.exr").string());
    ASSERT_TRUE(picture);
    EXPECT_FLOAT_EQ(picture->spec().get_float_attribute("ExposureTime"), 0.1f) << "one frame of ten in a second";
    std::vector<std::string> one{"render", "moving.gltf", "-o",     "one.exr", "--frame", "5",
                                 "--fps",  "10",          "--size", "48x32",   "--spp",   "4"};
    one.insert(one.end(), options.begin(), options.end() - 4);
    ASSERT_EQ(run(one).exit_code, kDone);
    EXPECT_EQ(pixels("a.0005.exr"), pixels("one.exr"));
    // Frames of another shutter are not taken for these.
    EXPECT_EQ(run(words("a.####.exr", "5", {"--clip", "slide", "--shutter", "-0.5,0.25"})).exit_code, kBadInput);
    EXPECT_EQ(
        run(words("a.####.exr", "5", {"--clip", "slide", "--shutter-segments", "4", "--shutter", "-0.5,0.5"})).exit_code,
        kBadInput);
}

TEST_F(Animate, ShardsTogetherAreTheWholeBitForBit)
{
    ASSERT_EQ(run(words("whole.####.exr", "0-6", {"--threads", "2"})).exit_code, kDone);
    for (const char* shard : {"1/3", "2/3", "3/3"})
        ASSERT_EQ(run(words("part.####.exr", "0-6", {"--shard", shard, "--threads", "1"})).exit_code, kDone);
    for (int frame = 0; frame <= 6; ++frame)
        EXPECT_EQ(pixels("whole.000" + std::to_string(frame) + ".exr"), pixels("part.000" + std::to_string(frame) + ".exr"))
            << frame;
}

TEST_F(Animate, LeavesFramesThatAreThereUnlessToldOtherwise)
{
    ASSERT_EQ(run(words("a.%04d.png", "1")).exit_code, kDone);
    const std::string first = bytes("a.0001.png");
    const Outcome o = run(words("a.%04d.png", "0-2", {"--stats", "-", "--threads", "1"}));
    ASSERT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_EQ(o.err, "");
    EXPECT_EQ(bytes("a.0001.png"), first);
    EXPECT_EQ(o.out.find("\"frame\": 1,"), std::string::npos);
    EXPECT_NE(o.out.find("\"frame\": 2,"), std::string::npos);
    const Outcome again = run(words("a.%04d.png", "0-2", {"--stats", "-", "--overwrite"}));
    ASSERT_EQ(again.exit_code, kDone);
    EXPECT_NE(again.out.find("\"frame\": 1,"), std::string::npos);
    const Outcome idle = run(words("a.%04d.png", "0-2", {"--progress", "plain"}));
    ASSERT_EQ(idle.exit_code, kDone);
    EXPECT_NE(idle.err.find("3 of 3 frames are there, whole and of these settings: nothing to do"), std::string::npos)
        << idle.err;
}

TEST_F(Animate, FramesThatAreNoWholePicturesAreMadeAgain)
{
    for (const std::string extension : {"exr", "png", "jpg", "tif", "hdr"}) {
        if (!is_long() && (extension == "jpg" || extension == "hdr")) continue;  // tif has their slow library, too
        const std::string pattern = "a.#." + extension;
        const auto name = [&](int frame) { return "a." + std::to_string(frame) + "." + extension; };
        ASSERT_EQ(run(words(pattern, "0-3")).exit_code, kDone);
        const auto good = pixels(name(1));
        fs::resize_file(folder / name(0), 0);
        fs::resize_file(folder / name(1), fs::file_size(folder / name(1)) - 3);
        std::ofstream(folder / name(2)) << "no picture at all";
        const Outcome o = run(words(pattern, "0-3", {"--stats", "-"}));
        EXPECT_EQ(o.exit_code, kDone) << o.err;
        for (int frame = 0; frame < 3; ++frame) {
            EXPECT_NE(o.err.find(name(frame)), std::string::npos) << o.err;
            EXPECT_NE(o.out.find("\"frame\": " + std::to_string(frame) + ","), std::string::npos);
        }
        EXPECT_EQ(o.out.find("\"frame\": 3,"), std::string::npos);
        EXPECT_EQ(pixels(name(1)), good) << extension;
    }
}

// A deadline stops a frame, whose file is whole all the same.
TEST_F(Animate, FramesThatADeadlineHasStoppedAreMadeAgainWithoutOne)
{
    for (const char* extension : {"exr", "png"}) {
        const std::string pattern = std::string("a.#.") + extension, name = std::string("a.0.") + extension;
        ASSERT_EQ(run(words("good" + pattern, "0", {"--clip", "slide"})).exit_code, kDone);
        ASSERT_EQ(run(words(pattern, "0", {"--clip", "slide", "--deadline", "1e-9"})).exit_code, kDone);
        const std::string stopped = bytes(name);
        EXPECT_NE(pixels(name), pixels("good" + name));
        ASSERT_EQ(run(words(pattern, "0", {"--clip", "slide", "--deadline", "2e-9"})).exit_code, kDone);
        EXPECT_EQ(bytes(name), stopped) << "a run with a deadline that is started again has nothing to do";
        EXPECT_EQ(run(words(pattern, "0", {"--clip", "rise"})).exit_code, kBadInput);
        const Outcome o = run(words(pattern, "0", {"--clip", "slide"}));
        EXPECT_EQ(o.exit_code, kDone);
        EXPECT_EQ(o.err, "occam: warning: " + name + ": was stopped before it was finished; it is made again\n");
        EXPECT_EQ(pixels(name), pixels("good" + name));
        EXPECT_EQ(run(words(pattern, "0", {"--clip", "slide"})).err, "");
    }
}

TEST_F(Animate, FramesThatAreToBeMadeAgainStayWhereARunIsRefused)
{
    ASSERT_EQ(run(words("a.#.png", "0", {"--clip", "slide", "--deadline", "1e-9"})).exit_code, kDone);
    ASSERT_EQ(run(words("a.#.png", "1", {"--clip", "rise"})).exit_code, kDone);
    const std::string stopped = bytes("a.0.png");
    EXPECT_EQ(run(words("a.#.png", "0-1", {"--clip", "slide"})).exit_code, kBadInput);
    EXPECT_EQ(bytes("a.0.png"), stopped);
}

TEST_F(Animate, FramesOfOtherSettingsAreRefused)
{
    for (const std::string extension : {"exr", "png", "jpg", "tif"}) {
        if (!is_long() && (extension == "jpg" || extension == "tif")) continue;  // KeepAnyNoteInEveryFormat has them
        const std::string pattern = "a.#." + extension;
        ASSERT_EQ(run(words(pattern, "0-2")).exit_code, kDone);
        const std::string before = bytes("a.0." + extension);
        std::vector<std::vector<std::string>> others = {words(pattern, "0-2", {"--seed", "7"}),
                                                        words(pattern, "2-3", {"--lod", "off"})};
        if (pattern == "a.#.exr")
            others.insert(others.end(),
                          {words(pattern, "0-2", {"--clip", "rise"}), words(pattern, "0-2", {}, "8"),
                           words(pattern, "0-2", {}, "4", "12"), words(pattern, "0-2", {"--crop", "0,0.5,0,1"})});
        for (const std::vector<std::string>& other : others) {
            const Outcome o = run(other);
            EXPECT_EQ(o.exit_code, kBadInput) << extension << ' ' << other.back();
            EXPECT_NE(o.err.find("--overwrite"), std::string::npos) << o.err;
        }
        EXPECT_FALSE(fs::exists(folder / ("a.3." + extension))) << "found before anything is made";
        EXPECT_EQ(run(words(pattern, "0-2", {"--clip", "fly"})).exit_code, kBadInput);
        EXPECT_EQ(bytes("a.0." + extension), before);
    }
    // The exposure of display formats is measured over the list of frames, unless it is given.
    const auto refusal = [&](const std::vector<std::string>& more) {
        std::vector<std::string> all{"--seed", "7"};
        all.insert(all.end(), more.begin(), more.end());
        return run(words("a.#.png", "0", all)).err;
    };
    EXPECT_NE(refusal({}).find("another list of frames asks for (--exposure); --overwrite"), std::string::npos);
    EXPECT_EQ(refusal({"--exposure", "0"}).find("(--exposure)"), std::string::npos);
    EXPECT_EQ(refusal({"--crop", "0,0.5,0,1"}).find("(--exposure)"), std::string::npos) << "of another size";
    if (!is_long()) return;  // another picture of a slow library
    ASSERT_EQ(run(words("b.#.hdr", "0")).exit_code, kDone);
    EXPECT_EQ(run(words("b.#.hdr", "0", {"--crop", "0,0.5,0,1"})).exit_code, kBadInput) << "of another size";
}

// Images without compression have as many bytes as others of their size.
TEST_F(Animate, FramesWithAnotherEnvironmentAreRefused)
{
    const auto write_sky = [&](const char* name, const std::string& texel) {
        std::ofstream file(folder / name, std::ios::binary);
        file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
        for (int i = 0; i < 8; ++i) file << texel;
    };
    write_sky("red.hdr", "\x60\x20\x10\x81");
    write_sky("blue.hdr", "\x10\x20\x60\x81");
    ASSERT_EQ(run(words("a.#.exr", "0", {"--environment", "red.hdr"})).exit_code, kDone);
    EXPECT_EQ(run(words("a.#.exr", "0", {"--environment", "red.hdr"})).exit_code, kDone);
    const Outcome other = run(words("a.#.exr", "0", {"--environment", "blue.hdr"}));
    EXPECT_EQ(other.exit_code, kBadInput) << "the frame of another environment was taken for whole and of these settings";
    EXPECT_NE(other.err.find("--overwrite"), std::string::npos) << other.err;
}

TEST_F(Animate, KilledAtAnyTimeEveryFrameIsWholeAndNoneIsMissing)
{
    const int frames = is_long() ? 40 : 20, rounds = is_long() ? 1000 : 10, step = is_long() ? 7919 : 15'838;
    const std::string all_frames = "0-" + std::to_string(frames - 1), last = "a.00" + std::to_string(frames - 1) + ".exr";
    ASSERT_EQ(run(words("good.####.exr", all_frames, {}, "64")).exit_code, kDone);
    for (int round = 0; round < rounds; ++round) {
        const pid_t child = start(words("a.####.exr", all_frames, {}, "64"));
        // The kills come later and later, so that they hit every stage: starting, reading, rendering, writing.
        std::this_thread::sleep_for(std::chrono::microseconds(2000 + step * round % 158'380));
        kill(child, SIGKILL);
        finish(child);
        for (const auto& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with("a.")) continue;
            ASSERT_EQ(pixels(name), pixels("good" + name.substr(1))) << name << " after kill " << round;
        }
        // When all frames are there, the next run would have nothing to do.
        if (fs::exists(folder / last))
            for (const auto& entry : fs::directory_iterator(folder))
                if (entry.path().filename().string().starts_with("a.00")) fs::remove(entry.path());
    }
    ASSERT_EQ(run(words("a.####.exr", all_frames, {}, "64")).exit_code, kDone);
    for (int frame = 0; frame < frames; ++frame) {
        const std::string name = (frame < 10 ? ".000" : ".00") + std::to_string(frame) + ".exr";
        ASSERT_EQ(pixels("a" + name), pixels("good" + name));
    }
}

TEST_F(Animate, AnInterruptLeavesNoPartOfAFrame)
{
    const pid_t child = start(words("a.####.exr", "0-3", {"--progress", "plain", "--threads", "1"}, "65536"));
    for (int i = 0; i < 1000 && text_of(folder / "stderr.txt").find("rendering") == std::string::npos; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(child, SIGINT);
    EXPECT_EQ(finish(child).exit_code, kInterrupted);
    for (const auto& entry : fs::directory_iterator(folder)) EXPECT_NE(entry.path().extension(), ".exr") << entry.path();
}

// The triangle is beside the first picture and fills the last one, which no format packs into so few bytes.
TEST_F(Animate, AFrameThatCannotBeWrittenIsExitCode3AndTheRestIsKept)
{
    before_exec = [] {
        const rlimit limit{16384, 16384};
        setrlimit(RLIMIT_FSIZE, &limit);
    };
    const Outcome o = run({"animate",      "moving.gltf", "-o",         "a.##.exr", "--frames",  "0,10",
                           "--fps",        "10",          "--clip",     "slide",    "--look-at", "2,-0.3,1.2,2,-0.3,0",
                           "--background", "off",         "--size",     "200x150",  "--spp",     "1",
                           "--stats",      "s.json",      "--progress", "openjd"});
    EXPECT_EQ(o.exit_code, kOutput);
    EXPECT_EQ(o.err.find("occam: a.10.exr: cannot be written"), 0u) << o.err;
    EXPECT_NE(o.out.find("openjd_fail: "), std::string::npos) << o.out;
    EXPECT_TRUE(fs::is_regular_file(folder / "a.00.exr"));
    const std::string stats = text_of(folder / "s.json");
    EXPECT_TRUE(stats.starts_with("[\n{\"frame\": 0,")) << "the finished frame has its statistics: " << stats;
    EXPECT_TRUE(stats.ends_with("]\n")) << stats;
    EXPECT_EQ(run(words("missing/a.####.exr", "0-1")).exit_code, kOutput);
}

TEST_F(Animate, WhatStandsInTheWayOfALaterFrameIsFoundBeforeTheFirst)
{
    fs::create_directories(folder / "a.0002.exr" / "in the way");
    mkfifo((folder / "b.0002.exr").c_str(), 0666);
    for (const std::string name : {"a", "b"})
        for (const auto& more : std::vector<std::vector<std::string>>{{}, {"--overwrite"}}) {
            const Outcome o = run(words(name + ".####.exr", "0-4", more));
            EXPECT_EQ(o.exit_code, kOutput);
            EXPECT_EQ(o.err, "occam: " + name + ".0002.exr: is there already and is not a file\n");
            EXPECT_FALSE(fs::exists(folder / (name + ".0000.exr")));
        }
}

// A file that cannot be read may be a whole frame. Whoever may read all files loses that right with the start of the
// program.
TEST_F(Animate, AFrameThatCannotBeReadIsRefusedWithTheSystemsReason)
{
    ASSERT_EQ(run(words("a.#.exr", "0-1")).exit_code, kDone);
    fs::permissions(folder / "a.1.exr", fs::perms::none);
    constexpr int kNotPossible = 97, kReadAll[] = {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH};
    before_exec = [&kReadAll] {
        for (const int right : kReadAll)
            if (geteuid() == 0 && prctl(PR_CAPBSET_DROP, right, 0, 0, 0) != 0) _exit(kNotPossible);
    };
    const Outcome o = run(words("a.#.exr", "0-1"));
    if (o.exit_code == kNotPossible) GTEST_SKIP() << "this user may read all files, and may not give that up";
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_EQ(o.err,
              "occam: a.1.exr: is there already, and cannot be read: Permission denied; --overwrite makes it again\n");
    const Outcome compared = run({"compare", "a.0.exr", "a.1.exr"});
    EXPECT_EQ(compared.err, "occam: a.1.exr: cannot be read: Permission denied\n");
    std::ofstream(folder / "s.json") << "not empty";
    fs::permissions(folder / "s.json", fs::perms::none);
    const Outcome stats = run(words("b.#.exr", "0", {"--stats", "s.json"}));
    EXPECT_EQ(stats.err, "occam: s.json: cannot be read: Permission denied (--stats)\n");
    EXPECT_EQ(run(words("a.#.exr", "0-1", {"--overwrite"})).exit_code, kDone);
}

TEST_F(Animate, APartThatSlurmChoosesIsTold)
{
    before_exec = [] {
        setenv("SLURM_ARRAY_TASK_ID", "2", 1);
        setenv("SLURM_ARRAY_TASK_COUNT", "3", 1);
        setenv("SLURM_ARRAY_TASK_MIN", "1", 1);
    };
    const Outcome part = run(words("a.#.exr", "0-3"));
    EXPECT_EQ(part.exit_code, kDone);
    EXPECT_EQ(part.err.find("occam: part 2 of 3 of the sequence is made, since Slurm's array variables say so"), 0u)
        << part.err;
    EXPECT_FALSE(fs::exists(folder / "a.0.exr"));
    EXPECT_TRUE(fs::exists(folder / "a.1.exr"));
    const Outcome whole = run(words("a.#.exr", "0-3", {"--shard", "1/1"}));
    EXPECT_EQ(whole.err, "");
    EXPECT_TRUE(fs::exists(folder / "a.3.exr"));
}

TEST_F(Animate, SpeaksOpenJobDescription)
{
    const Outcome o = run(words("a.####.exr", "0-3", {"--progress", "openjd"}));
    ASSERT_EQ(o.exit_code, kDone) << o.err;
    EXPECT_EQ(o.err, "");
    int last = -1;
    std::istringstream lines(o.out);
    for (std::string line; std::getline(lines, line);) {
        const bool is_progress = line.starts_with("openjd_progress: ");
        ASSERT_TRUE(is_progress || line.starts_with("openjd_status: ")) << line;
        if (!is_progress) continue;
        const int percent = std::stoi(line.substr(17));
        EXPECT_GE(percent, last) << o.out;
        last = percent;
    }
    EXPECT_EQ(last, 100);
    EXPECT_NE(o.out.find("frame 2 (3 of 4)"), std::string::npos) << o.out;
}

TEST_F(Animate, BadWordsAreOneLineAndExitCode2)
{
    for (const auto& bad : {words("a.exr", "0-3"), words("a.####.exr", "3-0"),
                            words("a.####.exr", "0-3", {"--shard", "4/3"}), words("a.####.exr", "0-3", {}, "4", "0"),
                            words("a.####.xyz", "0-3"), words("a.####.exr", "0-3", {"--clip", "7"})}) {
        const Outcome o = run(bad);
        EXPECT_EQ(o.exit_code, kBadInput) << o.err;
        EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    }
}

}  // namespace
}  // namespace occam
