// Tests of what `occam animate` takes for a finished frame of its own when it is started again.
#include <cstring>

#include "render/image.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

// A triangle, and a camera that flies past it for two seconds.
constexpr const char* kFlight = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
"nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"animations": [{"samplers": [{"input": 1, "output": 2}],
  "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}],
"buffers": [{"uri": "flight.bin", "byteLength": 68}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
{"buffer": 0, "byteOffset": 44, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
{"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2]},
{"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}]})";

class MadeFrames : public CommandTest {
protected:
    void SetUp() override
    {
        CommandTest::SetUp();
        const float numbers[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, /* times */ 0, 2, /* places */ -1.3f, 0.1f, 5, 1.7f, 0.3f, 4};
        std::ofstream(folder / "flight.bin", std::ios::binary).write(reinterpret_cast<const char*>(numbers), sizeof numbers);
        std::ofstream(folder / "flight.gltf") << kFlight;
    }
    std::vector<std::string> words(const std::string& pattern, const std::string& frames,
                                   const std::vector<std::string>& more = {}) const
    {
        std::vector<std::string> all{"animate", "flight.gltf", "-o",    pattern, "--frames",
                                     frames,    "--size",      "16x12", "--spp", "1"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

constexpr const char* kExtensions[] = {"exr", "png", "jpg", "tif", "hdr"};

// Whether the command is run for a format. By default it is run for exr and another one, since the library of the last three
// takes half a second to load. What differs between formats is how they keep a note, which is tested for all of them.
bool is_run(const std::string& extension, const char* other)
{
    return is_long() || extension == "exr" || extension == other;
}

TEST_F(MadeFrames, ThatWereStoppedAreMadeAgainInEveryFormat)
{
    for (const std::string extension : kExtensions) {
        if (!is_run(extension, "jpg")) continue;
        const std::string pattern = "a.#." + extension, name = "a.0." + extension;
        ASSERT_EQ(run(words(pattern, "0", {"--deadline", "1e-9"})).exit_code, kDone);
        const std::string stopped = text_of(folder / name);
        const Outcome o = run(words(pattern, "0"));
        EXPECT_EQ(o.exit_code, kDone);
        EXPECT_EQ(o.err, "occam: warning: " + name + ": was stopped before it was finished; it is made again\n");
        EXPECT_NE(text_of(folder / name), stopped) << extension;
        const std::string whole = text_of(folder / name);
        EXPECT_EQ(run(words(pattern, "0")).err, "");
        EXPECT_EQ(text_of(folder / name), whole) << extension;
    }
}

TEST_F(MadeFrames, OfOtherSettingsOrOfUnknownOnesAreRefusedInEveryFormat)
{
    render::Image image(16, 12);
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(16 * 12 * 3, 0.5f);
    for (const std::string extension : kExtensions) {
        if (!is_run(extension, "png")) continue;
        const std::string name = "a.0." + extension;
        ASSERT_EQ(run(words("a.#." + extension, "0")).exit_code, kDone);
        const Outcome other = run(words("a.#." + extension, "0", {"--seed", "7", "--progress", "plain"}));
        EXPECT_EQ(other.exit_code, kBadInput) << extension;
        EXPECT_NE(other.err.find("occam: " + name + ": is there already, and was made with other settings"),
                  std::string::npos)
            << other.err;
        image.write(folder / name);
        const Outcome unknown = run(words("a.#." + extension, "0"));
        EXPECT_EQ(unknown.exit_code, kBadInput) << extension;
        EXPECT_EQ(unknown.err, "occam: " + name +
                                   ": is there already, and does not say with which settings it was made; --overwrite makes "
                                   "it again\n");
        EXPECT_EQ(run(words("a.#." + extension, "0", {"--overwrite"})).exit_code, kDone);
        EXPECT_EQ(run(words("a.#." + extension, "0")).err, "") << extension;
    }
}

// The middle of a shutter is a moment that two formulas would round differently in some frames.
TEST_F(MadeFrames, OfACameraThatMovesAreKnownAgainWithAnyShutter)
{
    EveryNth some(2);
    for (const char* shutter : {"-0.4,0.8", "0,0.5", "-0.1,0.7", "0.3,0.9", "-0.5,0.5"}) {
        if (!some.takes()) continue;
        const std::vector<std::string> all = words("a.##.exr", "0-40", {"--fps", "24", "--shutter", shutter});
        ASSERT_EQ(run(all).exit_code, kDone) << shutter;
        const Outcome again = run(all);
        EXPECT_EQ(again.exit_code, kDone) << shutter << ": " << again.err;
        EXPECT_EQ(again.err, "") << shutter;
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == ".exr") fs::remove(entry.path());
    }
}

render::Image noise_of(int width, int height)
{
    render::Image image(width, height);
    std::uint32_t state = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B"}).pixels)
        value = float((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    return image;
}

TEST_F(MadeFrames, KeepAnyNoteInEveryFormat)
{
    const render::Image image = noise_of(33, 7);
    const std::string notes[] = {"Occam 0.1.0, recipe 0123456789abcdef", "one\ntwo",
                                 std::string(300, 'x') + "\n\n" + std::string(64, 'y') + "\nEXPOSURE=7",
                                 " a blank before and behind ", "-Y 3 +X 4"};
    for (const std::string extension : kExtensions)
        for (const std::string& note : notes) {
            const fs::path file = folder / ("a." + extension), plain = folder / ("b." + extension);
            image.write(file, {.exposure_ev = 0.0f, .note = note});
            image.write(plain, {.exposure_ev = 0.0f});
            EXPECT_EQ(render::Image::read_head(file).note, note) << extension;
            EXPECT_EQ(render::Image::read_head(plain).note, "") << extension;
            EXPECT_EQ(render::Image::read(file).layers()[0].pixels, render::Image::read(plain).layers()[0].pixels)
                << extension << ": " << note;
        }
}

// What follows a note is what a file without one holds, and a head of other programs has no note.
TEST_F(MadeFrames, HaveTheNoteOfRadianceFilesInComments)
{
    const render::Image image = noise_of(9, 5);
    image.write(folder / "a.hdr", {.note = "first\nsecond"});
    image.write(folder / "b.hdr");
    std::string text = text_of(folder / "a.hdr");
    const std::string comment = "#occam:note first\n#occam:note second\n";
    const std::size_t at = text.find(comment);
    ASSERT_EQ(at, std::strlen("#?RADIANCE\n"));
    text.erase(at, comment.size());
    EXPECT_EQ(text, text_of(folder / "b.hdr"));
    text.insert(at, "# made by hand\n");
    std::ofstream(folder / "c.hdr", std::ios::binary) << text;
    EXPECT_EQ(render::Image::read_head(folder / "c.hdr").note, "");
}

// The two begin at different ends. Whichever of them meets a frame of the other one must not take it for its own.
TEST_F(MadeFrames, OfARunWithOtherSettingsThatMakesThemMeanwhileAreRefused)
{
    for (const char* pattern : {"a.#.exr", "b.#.png"}) {
        const pid_t child = start(
            words(pattern, "0-9", {"--seed", "1", "--exposure", "0", "--size", "96x64", "--spp", "64"}));
        const Outcome other = run(
            words(pattern, "9,8,7,6,5,4,3,2,1,0", {"--seed", "2", "--exposure", "0", "--size", "96x64", "--spp", "64"}));
        const Outcome one = finish(child);
        EXPECT_FALSE(one.exit_code == kDone && other.exit_code == kDone) << pattern;
    }
}

TEST_F(MadeFrames, OfASceneWhoseFilesHaveChangedAreRefused)
{
    std::ofstream(folder / "red.mtl") << "newmtl a\nKd 1 0 0\nmap_Kd a.png\n";
    std::ofstream(folder / "named.obj") << "mtllib red.mtl\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    const auto named = [&] {
        std::vector<std::string> all = words("b.#.exr", "0-1");
        all[1] = "named.obj";
        return all;
    };
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--size", "8x8", "--spp", "1", "-q"}).exit_code, kDone);
    ASSERT_EQ(run(words("a.#.exr", "0-1")).exit_code, kDone);
    ASSERT_EQ(run(named()).exit_code, kDone);
    EXPECT_EQ(run(words("a.#.exr", "0-1")).exit_code, kDone);
    EXPECT_EQ(run(named()).exit_code, kDone);
    // Each of these changes leaves all counts and bounds as they were.
    const std::string image_before = text_of(folder / "a.png");
    ASSERT_EQ(run({"render", "triangle.obj", "-o", "a.png", "--size", "8x8", "--seed", "7", "-q"}).exit_code, kDone);
    EXPECT_EQ(run(named()).exit_code, kBadInput) << "another image";
    std::ofstream(folder / "a.png", std::ios::binary) << image_before;
    EXPECT_EQ(run(named()).exit_code, kDone);
    std::ofstream(folder / "red.mtl") << "newmtl a\nKd 0 1 0\nmap_Kd a.png\n";
    EXPECT_EQ(run(named()).exit_code, kBadInput) << "another material library";
    std::fstream buffer(folder / "flight.bin", std::ios::binary | std::ios::in | std::ios::out);
    const float later = 1.5f;
    buffer.seekp(60).write(reinterpret_cast<const char*>(&later), sizeof later);
    buffer.close();
    EXPECT_EQ(run(words("a.#.exr", "0-1")).exit_code, kBadInput) << "another buffer";
}

// The triangle, and two cameras in one place whose pixels differ in size.
constexpr const char* kTwoSizes = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
"nodes": [{"mesh": 0}, {"name": "A", "camera": 0, "translation": [0, 0, 5]},
{"name": "B", "camera": 1, "translation": [0, 0, 5]}],
"cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 0.1, "zfar": 9}},
{"type": "orthographic", "orthographic": {"xmag": 200, "ymag": 200, "znear": 0.1, "zfar": 9}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"buffers": [{"uri": "flight.bin", "byteLength": 68}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}]})";

TEST_F(MadeFrames, WithTheDetailOfAnotherCameraAreRefused)
{
    std::ofstream(folder / "sizes.gltf") << kTwoSizes;
    const auto outcome = [&](const char* camera) {
        return run({"animate", "sizes.gltf", "-o", "a.#.exr", "--frames", "0", "--size", "16x12", "--spp", "1", "--camera",
                    "A", "--lod-camera", camera, "--stats", "-"});
    };
    const Outcome first = outcome("A");
    ASSERT_EQ(first.exit_code, kDone) << first.err;
    EXPECT_NE(first.out.find("\"height\": 4.0"), std::string::npos) << first.out;
    EXPECT_EQ(outcome("B").exit_code, kBadInput);
    EXPECT_EQ(outcome("A").exit_code, kDone);
}

}  // namespace
}  // namespace occam
