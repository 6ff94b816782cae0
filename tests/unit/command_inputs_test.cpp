// Tests that no command writes over a file that it reads, or that the scene names, whatever that file is called.
#include "io/import/import.h"
#include "render/image.h"
#include "tests/support/command_test.h"

namespace occam {
namespace {

using namespace test;

constexpr const char* kTriangle = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n";

// A triangle in an external buffer, beside one that a file of polygons holds; an image is used and another one is not.
constexpr const char* kScene = R"({"asset": {"version": "2.0"}, "scene": 0,
"scenes": [{"nodes": [0, 1], "extras": {"occam": {"environment": {"image": "sky.png", "strength": 1}}}}],
"nodes": [{"mesh": 0}, {"extras": {"occam": {"cage": "cage.png"}}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
"textures": [{"source": 0}], "images": [{"uri": "used.png"}, {"uri": "un%75sed.png"}],
"buffers": [{"uri": "buffer.png", "byteLength": 36}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}]})";

class Inputs : public CommandTest {
protected:
    void SetUp() override
    {
        CommandTest::SetUp();
        render::Image image(2, 2);
        image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(12, 0.5f);
        for (const char* name : {"used.png", "unused.png", "sky.png", "map.png", "sheen.png", "map.exr"})
            image.write(folder / name);
        const float numbers[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0};
        std::ofstream(folder / "buffer.png", std::ios::binary).write(reinterpret_cast<const char*>(numbers), sizeof numbers);
        std::ofstream(folder / "cage.png") << "mtllib library.exr\n" << kTriangle;
        std::ofstream(folder / "library.exr")
            << "newmtl red\nmap_Kd map.png\nnewmtl unused\nmap_Ps sheen.png\nmap_Ke map.exr\n";
        std::ofstream(folder / "scene.gltf") << kScene;
        std::ofstream(folder / "scene.obj") << "mtllib library.exr\n" << kTriangle;
    }
    // Runs a command that must refuse to write `output`.
    void expect_refusal(const std::vector<std::string>& words, const std::string& output)
    {
        const std::string before = text_of(folder / output);
        const Outcome o = run(words);
        EXPECT_EQ(o.exit_code, kBadInput) << words[1] << ": " << o.err;
        EXPECT_EQ(o.err, "occam: " + output + ": is an input, so it cannot be written\n") << words[1];
        EXPECT_EQ(text_of(folder / output), before) << output;
    }
    std::vector<std::string> render(const std::string& scene, const std::string& output) const
    {
        return {"render", scene, "-o", output, "--size", "4x4", "--spp", "1"};
    }
};

TEST_F(Inputs, OfASceneAreNotOverwritten)
{
    for (const char* name : {"buffer.png", "cage.png", "library.exr", "used.png", "unused.png", "sky.png", "map.png"})
        expect_refusal(render("scene.gltf", name), name);
    for (const char* name : {"library.exr", "map.png", "map.exr", "sheen.png"})
        expect_refusal(render("scene.obj", name), name);
    EXPECT_EQ(run(render("scene.gltf", "a.png")).exit_code, kDone);
    EXPECT_EQ(run(render("scene.obj", "used.png")).exit_code, kDone) << "an image of another scene";
}

TEST_F(Inputs, AreKnownByAnyName)
{
    fs::create_hard_link(folder / "buffer.png", folder / "hard.png");
    fs::create_symlink("buffer.png", folder / "soft.png");
    fs::create_directory_symlink(".", folder / "here");
    for (const std::string name : {"hard.png", "soft.png", "here/buffer.png", "here/./here/buffer.png"})
        expect_refusal(render("here/scene.gltf", name), name);
}

TEST_F(Inputs, OfASequenceAreNotOverwrittenByAnyFrame)
{
    fs::rename(folder / "buffer.png", folder / "frame.2.png");
    std::string text = kScene;
    text.replace(text.find("buffer.png"), 10, "frame.2.png");
    std::ofstream(folder / "scene.gltf") << text;
    const std::vector<std::string> words{"animate", "scene.gltf", "-o",    "frame.#.png", "--frames",   "0-3",
                                         "--size",  "4x4",        "--spp", "1",           "--overwrite"};
    expect_refusal(words, "frame.2.png");
    EXPECT_FALSE(fs::exists(folder / "frame.0.png")) << "found before anything is made";
}

TEST_F(Inputs, OfAnEmptyFileAreNotReplacedByStatistics)
{
    // Statistics replace empty files, so these must not be inputs.
    std::ofstream(folder / "empty.mtl");
    std::ofstream(folder / "scene.obj") << "mtllib empty.mtl\n" << kTriangle;
    std::vector<std::string> words = render("scene.obj", "a.png");
    words.insert(words.end(), {"--stats", "empty.mtl"});
    expect_refusal(words, "empty.mtl");
    EXPECT_FALSE(fs::exists(folder / "a.png"));
}

TEST_F(Inputs, OfOtherCommandsAreNotOverwritten)
{
    fs::create_hard_link(folder / "map.png", folder / "hard.png");
    expect_refusal({"compare", "map.png", "used.png", "--heat", "hard.png"}, "hard.png");
    expect_refusal({"compare", "used.png", "map.png", "--heat", "./map.png"}, "./map.png");
    expect_refusal({"texture", "map.png", "hard.png"}, "hard.png");
    expect_refusal({"texture", "map.png", "./map.png"}, "./map.png");
}

TEST_F(Inputs, AreListedInTheScene)
{
    const auto names_of = [](const Scene& scene) {
        std::vector<std::string> names;
        for (const fs::path& file : scene.files) names.push_back(file.filename().string());
        std::sort(names.begin(), names.end());
        return names;
    };
    Scene scene = load(folder / "scene.gltf");
    EXPECT_EQ(names_of(scene), (std::vector<std::string>{"buffer.png", "cage.png", "library.exr", "map.exr", "map.png",
                                                         "scene.gltf", "sheen.png", "sky.png", "unused.png", "used.png"}));
    scene.add(load(folder / "triangle.obj"), scene.root());
    EXPECT_EQ(scene.files.back().filename(), "triangle.obj") << "what is added brings its files";
}

}  // namespace
}  // namespace occam
