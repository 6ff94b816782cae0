// Tests of what the command says of names, files and numbers that it refuses.
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/stat.h>

#include "render/image.h"
#include "tests/support/campaign.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

class Refusals : public CommandTest {
protected:
    void expect_refusal(const std::vector<std::string>& words, const std::string& line)
    {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << words[0] << ' ' << words.back();
        EXPECT_EQ(o.err, "occam: " + line + "\n");
    }
};

TEST_F(Refusals, OfAPictureWithoutAFormatDoNotSpeakOfOtherOptions)
{
    fs::create_directory(folder / "kept");
    const std::string why = ": has no extension of a format that can be written: .exr .hdr .png .jpg .tif";
    EveryNth some(5);
    for (const std::vector<std::string>& idle : std::vector<std::vector<std::string>>{
             {}, {"--exposure", "0"}, {"--tonemap", "srgb"}, {"--exr", "half"}, {"--aov", "depth"}}) {
        for (const std::string name : {".png", "-", "/dev/null", "a", "a.xyz", "kept/.exr"}) {
            if (!some.takes()) continue;
            std::vector<std::string> words{"render", "triangle.obj", "-o", name};
            words.insert(words.end(), idle.begin(), idle.end());
            expect_refusal(words, name + why);
        }
        std::vector<std::string> words{"render", "triangle.obj", "-o", "kept/"};
        words.insert(words.end(), idle.begin(), idle.end());
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kOutput);
        EXPECT_EQ(o.err, "occam: kept/: is the name of a folder, not of a file\n");
    }
    expect_refusal({"animate", "triangle.obj", "-o", "a.#.xyz", "--frames", "0", "--exposure", "0"}, "a.0.xyz" + why);
}

TEST_F(Refusals, OfFilesThatCannotBeReadGiveTheReason)
{
    constexpr int kMayReadAll = 97;
    fs::create_directory(folder / "closed");
    render::Image image(2, 2);
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(12, 0.5f);
    for (const char* extension : {"obj", "ply", "stl", "off", "gltf", "glb", "png"}) {
        const std::string name = std::string("a.") + extension;
        std::ofstream(folder / name) << "something";
        fs::permissions(folder / name, fs::perms::none);
        std::ofstream(folder / "closed" / name) << "something";
    }
    std::ofstream(folder / "buffer.gltf")
        << R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "a.glb", "byteLength": 4}]})";
    fs::permissions(folder / "closed", fs::perms::none);
    before_exec = [] {
        for (const int right : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH})
            if (geteuid() == 0 && prctl(PR_CAPBSET_DROP, right, 0, 0, 0) != 0) _exit(kMayReadAll);
    };
    if (run({"--version"}).exit_code == kMayReadAll) GTEST_SKIP() << "this user may not give up rights";
    for (const char* extension : {"obj", "ply", "stl", "off", "gltf", "glb"})
        for (const std::string& name : {std::string("a.") + extension, std::string("closed/a.") + extension})
            expect_refusal({"info", name}, name + ": cannot be read: Permission denied");
    const Outcome buffer = run({"info", "buffer.gltf"});
    EXPECT_EQ(buffer.exit_code, kBadInput);
    EXPECT_NE(buffer.err.find("a.glb: cannot be read: Permission denied"), std::string::npos) << buffer.err;
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"texture", "a.png", "b.tx"},
                                               {"compare", "a.png", "a.png"},
                                               {"render", "-o", "b.png", "--environment", "a.png"}}) {
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << words[0];
        EXPECT_NE(o.err.find("a.png: cannot be read: Permission denied"), std::string::npos) << words[0] << ": " << o.err;
    }
    before_exec = nullptr;
    fs::permissions(folder / "closed", fs::perms::all);
    expect_refusal({"info", "missing.obj"}, "missing.obj: no such file");
    expect_refusal({"info", "a.obj/b.obj"}, "a.obj/b.obj: no such file");
    expect_refusal({"info", "closed"}, "closed: is a folder; name a scene file in it");
}

TEST_F(Refusals, OfEnvironmentsNameThemAsTheUserDoes)
{
    fs::create_directory(folder / "skies");
    std::ofstream(folder / "skies" / "bad.hdr") << "no image";
    for (const std::string& name : {std::string("skies/bad.hdr"), (folder / "skies" / "bad.hdr").string()}) {
        const Outcome o = run({"render", "triangle.obj", "-o", "b.png", "--environment", name});
        EXPECT_EQ(o.exit_code, kBadInput) << name;
        EXPECT_TRUE(o.err.starts_with("occam: " + name + ": not an image of a format that is read")) << o.err;
    }
}

// Such a file may have no end, or wait for a writer for ever.
TEST_F(Refusals, OfEnvironmentsThatAreNoFilesComeBeforeTheyAreRead)
{
    ASSERT_EQ(mkfifo((folder / "pipe.png").c_str(), 0600), 0);
    before_exec = [] { alarm(20); };
    for (const std::string name : {"pipe.png", "/dev/zero", "none.png"}) {
        const std::string why = name + ": is not there or is not a file (--environment)";
        expect_refusal({"render", "triangle.obj", "-o", "b.png", "--environment", name}, why);
        expect_refusal({"animate", "triangle.obj", "-o", "b.#.png", "--frames", "0", "--environment", name}, why);
    }
    before_exec = nullptr;
}

// Numbers are judged before anything is computed from them.
TEST_F(Refusals, OfNumbersComeBeforeTheyOverflow)
{
    std::ofstream(folder / "flat.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"camera": 0}], "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1,
"aspectRatio": 1e-7}}]})";
    const auto size_of = [](const std::string& name) {
        return "expected from 1 to 65536 pixels a side, not " + name + " (size)";
    };
    const auto crop_of = [](const std::string& shares) {
        return "expected shares of the frame with 0 <= X0 < X1 <= 1 and 0 <= Y0 < Y1 <= 1, not " + shares + " (crop)";
    };
    ASSERT_EQ(run({"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0", "--size", "4x4", "--spp", "1"}).exit_code,
              kDone);
    for (const char* name : {"1x30000000", "2000000000x2000000000", "1x65537"}) {
        expect_refusal({"render", "triangle.obj", "-o", "b.png", "--size", name}, size_of(name));
        expect_refusal({"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0", "--size", name}, size_of(name));
        expect_refusal({"animate", "triangle.obj", "-o", "a.#.exr", "--frames", "0", "--size", name}, size_of(name));
    }
    for (const char* share : {"0,1.00000002e+30,0,1", "-1.00000002e+30,1,0,1", "0,1,0,9.99999968e+37", "0,1,0.75,0.5"}) {
        const std::string crop = crop_of(share);
        expect_refusal({"render", "triangle.obj", "-o", "b.png", std::string("--crop=") + share}, crop);
        expect_refusal(
            {"animate", "triangle.obj", "-o", "a.#.png", "--frames", "0", "--size", "4x4", std::string("--crop=") + share},
            crop);
    }
    // The height that follows from such an aspect is the largest one.
    const Outcome flat = run({"render", "flat.gltf", "-o", "b.exr", "--crop", "0,0.01,0,0.001", "--spp", "1"});
    EXPECT_EQ(flat.exit_code, kDone) << flat.err;
    EXPECT_EQ(render::Image::read_head(folder / "b.exr").height, 66);
}

// A texture whose head is right and whose texels cannot be decoded.
TEST_F(Refusals, OfATextureComeAlsoWhereOneSampleIsReplayed)
{
    render::Image image(64, 64);
    std::uint32_t state = 1;
    for (float& value : image.add_layer("beauty", {"R", "G", "B"}).pixels)
        value = float((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f;
    image.write(folder / "noise.png");
    std::string bytes = text_of(folder / "noise.png");
    bytes.replace(bytes.size() / 2, 64, std::string(64, '\0'));
    std::ofstream(folder / "noise.png", std::ios::binary) << bytes;
    std::ofstream(folder / "red.mtl") << "newmtl red\nmap_Kd noise.png\nmap_Bump missing.png\n";
    std::ofstream(folder / "scene.obj")
        << "mtllib red.mtl\nv -9 -9 0\nv 9 -9 0\nv 0 9 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\n"
           "f 1/1 2/2 3/3\n";
    const std::vector<std::string> words{"render", "scene.obj", "-o", "a.exr", "--size", "8x8", "--spp", "1"};
    const Outcome rendered = run(words);
    ASSERT_EQ(rendered.exit_code, kBadInput) << rendered.err;
    std::vector<std::string> replay = words;
    replay.insert(replay.end(), {"--replay", "4,4"});
    const Outcome o = run(replay);
    EXPECT_EQ(o.exit_code, kBadInput);
    EXPECT_NE(o.err.find("noise.png"), std::string::npos) << o.err;
    EXPECT_TRUE(o.err.ends_with(rendered.err)) << "the same refusal: " << o.err << rendered.err;
    EXPECT_NE(o.err.find("warning: image file is missing (missing.png)"), std::string::npos) << o.err;
}

}  // namespace
}  // namespace occam
