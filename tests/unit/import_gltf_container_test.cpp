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

}  // namespace
}  // namespace occam::test
