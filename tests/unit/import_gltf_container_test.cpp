// Tests of GLB containers, and of buffers beside a glTF.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "tests/support/campaign.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

TEST(ImportGltfContainer, ReadsTheSameFromAGlb)
{
    const TempFolder folder;
    const Gltf g = square();
    const Scene whole = load(folder.write("a.glb", g.glb())), parts = load(g.write(folder));
    const auto a = cages(whole), b = cages(parts);
    ASSERT_EQ(a.size(), 1u);
    ASSERT_EQ(b.size(), 1u);
    EXPECT_EQ(a[0]->positions, b[0]->positions);
    EXPECT_EQ(a[0]->face_vertices, b[0]->face_vertices);
    EXPECT_TRUE(whole.warnings.empty()) << whole.warnings[0];
}

TEST(ImportGltfContainer, BrokenFramesAreRefused)
{
    const TempFolder folder;
    const std::string glb = square().glb();
    EXPECT_NE(error_of(folder.write("b.glb", glb.substr(0, glb.size() - 4))).find("declared length"), std::string::npos);
    std::string longer = glb;
    longer[12] = '\x7f';
    EXPECT_NE(error_of(folder.write("c.glb", longer)).find("GLB container"), std::string::npos);
    for (std::size_t size = 4; size < glb.size(); size += is_long() ? 1 : 7)
        EXPECT_NE(error_of(folder.write("cut.glb", glb.substr(0, size))), "") << size;
}

TEST(ImportGltfContainer, ABufferLongerThanItsChunkIsRefused)
{
    const TempFolder folder;
    const Gltf g = square();
    const std::string glb = g.glb();
    const std::string from = "{\"byteLength\": " + std::to_string(g.bin.size()), to = "{\"byteLength\": 99";
    std::string broken = glb;
    const std::size_t at = broken.find(from);
    ASSERT_NE(at, std::string::npos);
    broken.replace(at, from.size(), to);
    ASSERT_EQ(broken.size(), glb.size()) << "both numbers have two digits";
    EXPECT_NE(error_of(folder.write("short.glb", broken)).find("binary chunk is missing, or shorter"), std::string::npos);
}

TEST(ImportGltfContainer, AChunkThatIsMissingIsRefused)
{
    const TempFolder folder;
    Gltf g = square();
    const std::string bin = std::exchange(g.bin, {});
    g.more = ", \"buffers\": [{\"byteLength\": " + std::to_string(bin.size()) + "}], \"bufferViews\": [" + g.buffer_views +
             "]";
    EXPECT_NE(error_of(folder.write("none.glb", g.glb())).find("binary chunk is missing"), std::string::npos);
}

// glTF 2.0, sec. 3.6.1.1: the file must hold at least what the buffer says.
TEST(ImportGltfContainer, MessagesNameTheBufferThatCannotBeRead)
{
    const TempFolder folder;
    folder.write("four.bin", "1234");
    std::filesystem::create_directories(folder.path() / "sub");
    const std::pair<std::string, std::string> sources[] = {
        {"none.bin", "the file of the buffer is missing, or no regular file: none.bin (buffers[1])"},
        {"sub", "the file of the buffer is missing, or no regular file: sub (buffers[1])"},
        {"../none.bin", "the file of the buffer is not in the scene's folder: ../none.bin (buffers[1])"},
        {"four.bin", "the file of the buffer has 4 bytes, and byteLength is 47: four.bin (buffers[1])"},
        {"data:audio/wav;base64,AAAA", "the data URI is not in base64, or its media type is not read: data:audio/wav"},
        {"data:application/octet-stream,AAAA", "the data URI is not in base64, or its media type is not read"}};
    for (const auto& [uri, why] : sources) {
        Gltf g = square();
        std::string text = g.json();
        g.write(folder);
        const std::size_t end = text.find("}]", text.find("\"buffers\""));
        text.insert(end + 1, R"(, {"byteLength": 47, "uri": ")" + uri + "\"}");
        const std::string error = error_of(folder.write("other.gltf", text));
        EXPECT_NE(error.find(why), std::string::npos) << error;
    }
}

TEST(ImportGltfContainer, AFileMayBeLongerThanItsBufferButNotShorter)
{
    const TempFolder folder;
    const Gltf g = square();
    const auto file = g.write(folder);
    folder.write("data file.bin", g.bin + "more");
    EXPECT_EQ(cages(load(file)).at(0)->face_count(), 2u);
    folder.write("data file.bin", g.bin.substr(1));
    EXPECT_NE(error_of(file), "");
}

// In the path of a URI a plus sign is a plus sign (RFC 3986), and a percent sign may be one, too.
TEST(ImportGltfContainer, FilesOfBuffersMayHaveAnyName)
{
    const TempFolder folder;
    const std::pair<const char*, const char*> names[] = {{"a+b.bin", "a+b.bin"},     {"C++.bin", "C%2B%2b.bin"},
                                                         {"d%zz.bin", "d%zz.bin"},   {"e%.bin", "e%25.bin"},
                                                         {"f.bin", "./f.bin"},       {"<binary chunk>", "<binary chunk>"},
                                                         {"g%00.bin", "g%2500.bin"}, {"<buffer 1>", "<buffer 1>"}};
    for (const auto& [name, uri] : names) {
        const Gltf g = square();
        std::string text = g.json();
        const std::string from = "data%20file.bin";
        text.replace(text.find(from), from.size(), uri);
        folder.write(name, g.bin);
        const auto file = folder.write("names.gltf", text);
        EXPECT_EQ(error_of(file, {.strict = true}), "") << uri;
        const Scene scene = load(file);
        EXPECT_EQ(cages(scene).at(0)->face_count(), 2u) << uri;
        EXPECT_EQ(scene.files.size(), 2u) << uri;
    }
}

// An image is the file of its name, even if our own name of a buffer is the same.
TEST(ImportGltfContainer, AnImageIsNoBuffer)
{
    const TempFolder folder;
    folder.write("<buffer 0>", "image");
    Gltf g = square(R"(, "material": 0)");
    g.more = R"(, "images": [{"uri": "<buffer 0>"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])";
    const Scene scene = load(g.write(folder));
    const Texture& image = scene.texture(scene.material(cages(scene).at(0)->materials.at(0)).base_color_texture.texture);
    EXPECT_FALSE(image.encoded);
    EXPECT_EQ(image.path.filename(), "<buffer 0>");
}

TEST(ImportGltfContainer, ADataUriMayBeLongerThanItsBufferButNotShorter)
{
    const TempFolder folder;
    const auto with = [&](const std::string& base64) {
        return folder.write("data.gltf", R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36,
            "uri": "data:application/octet-stream;base64,)" +
                                             base64 + R"("}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126,
            "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}]})");
    };
    const std::string whole = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    for (const char* more : {"", "AAAAAAA=", "AA==", "\\n"}) {
        EXPECT_EQ(error_of(with(whole + more), {.strict = true}), "") << more;
        EXPECT_EQ(cages(load(with(whole + more))).at(0)->positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    }
    for (const auto& [text, bytes] :
         {std::pair(whole.substr(0, 47) + "=", "35"), std::pair(whole.substr(0, 46) + "==", "34"),
          std::pair(" " + whole, "0"), std::pair(std::string(), "0")}) {
        const std::string error = error_of(with(text));
        EXPECT_NE(error.find("the data URI of the buffer has " + std::string(bytes) + " bytes, and byteLength is 36: data:"),
                  std::string::npos)
            << error;
        EXPECT_NE(error.find("(buffers[0])"), std::string::npos) << error;
    }
}

}  // namespace
}  // namespace occam::test
