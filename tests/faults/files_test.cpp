// Files that are read and written while there is not enough memory: an error, nothing lost, and no half a file.
#include <gtest/gtest.h>

#include "occam/occam.h"
#include "tests/faults/fail_everywhere.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/temp_folder.h"
#include "tests/support/webp_files.h"

namespace occam::test {
namespace {

namespace fs = std::filesystem;

/// Returns a picture with a gradient.
Image gradient(int side)
{
    Image image(side, side);
    Layer& beauty = image.add_layer("beauty", {"R", "G", "B", "A"}, false);
    for (std::size_t i = 0; i < beauty.pixels.size(); ++i) beauty.pixels[i] = float(i % 97) / 96;
    return image;
}

class FailingFiles : public testing::Test {
protected:
    void SetUp() override
    {
        if (kIsSanitized) GTEST_SKIP() << "sanitizers have an operator new of their own";
        gradient(8).write(temp.path() / "tiles.png");
        gradient(8).write(temp.path() / "tiles.exr");
        gradient(8).write(temp.path() / "tiles.jpg");
        Image::read(temp.path() / "tiles.jpg");  // loads the libraries for pictures, before anything fails
    }
    /// Reads a scene file and renders it, which reads its textures.
    void read_everywhere(const fs::path& file, const Density& density)
    {
        const auto read = [&] {
            Scene scene = load(file);
            const Camera camera = Camera::look_at({0.5, 0.5, 3}, {0.5, 0.5, 0}, {0, 1, 0}, 0.8f);
            return Renderer({.threads = 1})
                .render(scene, camera, {.width = 6, .height = 4, .spp = 1, .integrator = IntegratorKind::Direct})
                .checksum();
        };
        const std::uint64_t wanted = read();
        const auto attempt = [&] { EXPECT_EQ(read(), wanted); };
        fail_everywhere(density, attempt, [&](bool) { attempt(); });
    }

    const TempFolder temp;
};

Gltf textured(const std::string& image)
{
    Gltf g = square(R"(, "material": 0)");
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})");
    g.meshes =
        R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}],
        "extras": {"occam": {"scheme": "catmull-clark", "displacement": {"texture": 0, "scale": 0.1}}}})";
    g.nodes = R"({"mesh": 0, "name": "a square"}, {"camera": 0, "translation": [0, 0, 4]})";
    g.more = R"(, "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 3, "output": 4}]}], "images": [{"uri": ")" +
             image + R"("}])";
    g.put<float>({0, 1});
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]})");
    g.put<float>({0, 0, 0, 0, 0, 1});
    g.accessor(R"({"bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3"})");
    return g;
}

TEST_F(FailingFiles, WithTexturesAreReadOrRefused)
{
    const Density density{.dense = 4, .growth = 1.5, .may_lose_blocks = true};
    read_everywhere(textured("tiles.png").write(temp, "png.gltf"), density);
    read_everywhere(textured("tiles.exr").write(temp, "exr.gltf"), density);
    temp.write("tiles.webp", kWebpFile);
    read_everywhere(textured("tiles.webp").write(temp, "webp.gltf"), density);
}

TEST_F(FailingFiles, OfEveryFormatAreReadOrRefused)
{
    temp.write("paint.mtl", "newmtl tiles\nKd 1 0.5 0.2\nmap_Kd tiles.png\n");
    const char* const kObj =
        "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl tiles\n"
        "f 1/1 2/2 3/3 4/4\nt crease 2/1/0 0 1 2.5\n";
    // OpenSubdiv loses a channel of texture coordinates that it cannot complete.
    read_everywhere(temp.write("square.obj", kObj), {.growth = 1.5, .may_lose_blocks = true});
    read_everywhere(temp.write("square.ply",
                               "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
                               "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 "
                               "0\n0 1 0\n4 0 1 2 3\n"),
                    {.growth = 2});
    read_everywhere(temp.write("square.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"), {.growth = 2});
    read_everywhere(temp.write("triangle.stl",
                               "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
                               "0\nendloop\nendfacet\nendsolid s\n"),
                    {.growth = 2});
}

TEST_F(FailingFiles, OfPicturesAreWrittenAsAWholeOrNotAtAll)
{
    Image image = gradient(24);
    // Copies of texts and of long names need memory.
    image.attributes.push_back({"a name of more than fifteen letters", 1.0f});
    image.attributes.push_back({"comments", std::string("a text of more than fifteen letters")});
    image.attributes.push_back({"matrix", std::array<float, 16>{}});
    fail_everywhere(
        {}, [&] { const Image copy = image; }, [](bool) {});
    // OpenImageIO opens a TIFF in a constructor that may not throw: a lack of memory there ends the process.
    for (const char* name : {"a.png", "a.exr", "a.hdr", "a.jpg"}) {
        SCOPED_TRACE(name);
        const TempFolder folder;
        const fs::path file = folder.path() / name;
        image.write(file);
        const std::uint64_t wanted = Image::read(file).checksum();
        fs::remove(file);
        fail_everywhere(
            {.dense = 24, .growth = 1.6, .may_lose_blocks = true}, [&] { image.write(file); },
            [&](bool has_thrown) {
                EXPECT_EQ(fs::exists(file), !has_thrown);
                if (!has_thrown) {
                    EXPECT_EQ(Image::read(file).checksum(), wanted);
                }
                fs::remove(file);
                EXPECT_TRUE(fs::is_empty(folder.path())) << "a temporary file is left";
                image.write(file);
                EXPECT_EQ(Image::read(file).checksum(), wanted);
                fs::remove(file);
            });
    }
}

}  // namespace
}  // namespace occam::test
