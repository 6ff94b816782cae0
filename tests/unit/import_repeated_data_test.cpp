// Tests that what a small file names very many times is read once and kept once, or refused.
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/bytes_read.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

constexpr std::size_t kMega = 1'000'000;
constexpr const char* kCopies = "the copies that elements share out of the file take more than 512 MiB";
constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

std::string list_of(int count, const std::function<std::string(int)>& element)
{
    std::string list;
    for (int i = 0; i < count; ++i) list += (i ? ", " : "") + element(i);
    return list;
}

// Returns one of many spellings of the name of a file.
std::string spelling(int number, const std::string& name)
{
    std::string text;
    for (int i = 0; i < number; ++i) text += "./";
    return text + name;
}

// Returns a PPM of grey texels that takes more than 700,000 bytes.
std::string large_image() { return "P6\n500 500\n255\n" + std::string(750'000, '\x80'); }

std::string images(int count, const std::function<std::string(int)>& image, bool are_used)
{
    std::string text = R"(, "images": [)" + list_of(count, image) + "]";
    if (!are_used) return text;
    text += R"(, "textures": [)" + list_of(count, [](int i) { return R"({"source": )" + std::to_string(i) + "}"; }) + "]";
    return text + R"(, "materials": [)" +
           list_of(count, [](int i) { return R"({"emissiveTexture": {"index": )" + std::to_string(i) + "}}"; }) + "]";
}

// Adds views of all bytes but the last `step` ones of each view before, with an image in each.
Gltf with_views(int count, int step, bool are_used)
{
    Gltf g = square();
    g.bin.resize(kMega);
    for (int i = 0; i < count; ++i)
        g.buffer_views += R"(, {"buffer": 0, "byteLength": )" + std::to_string(kMega - std::size_t(step * i)) + "}";
    const auto image = [](int i) { return R"({"bufferView": )" + std::to_string(i + 2) + R"(, "mimeType": "image/png"})"; };
    g.more = images(count, image, are_used);
    return g;
}

TEST(RepeatedImages, OfTheSameBytesAreOneTexture)
{
    const TempFolder folder;
    EXPECT_EQ(load(with_views(100, 0, true).write(folder)).texture_ids().size(), 1u);
    EXPECT_TRUE(warns(load(with_views(100, 0, false).write(folder)), "unused image cannot be read (images[0])"));
}

TEST(RepeatedImages, WhoseViewsOverlapManyTimesAreRefused)
{
    const TempFolder folder;
    for (const bool are_used : {false, true}) {
        EXPECT_EQ(error_of(with_views(10, 4, are_used).write(folder)), "");
        EXPECT_NE(error_of(with_views(40, 4, are_used).write(folder)).find("show far more bytes than the buffers hold"),
                  std::string::npos);
    }
}

TEST(RepeatedImages, OfManySpellingsAreOneTextureAndReadOnce)
{
    const TempFolder folder;
    folder.write("a.ppm", large_image());
    Gltf g = square();
    const auto image = [](int i) { return R"({"uri": ")" + spelling(i, "a.ppm") + R"("})"; };
    g.more = images(50, image, true);
    EXPECT_EQ(load(g.write(folder)).texture_ids().size(), 1u);
    g.more = images(50, image, false);
    const auto file = g.write(folder);
    const std::size_t before = bytes_read();
    load(file);
    EXPECT_LT(bytes_read() - before, 3 * kMega);
}

TEST(RepeatedImages, OutsideOfTheFolderDoNotStandForThoseInside)
{
    const TempFolder folder;
    const std::string inside = folder.write("a.ppm", large_image()).string();
    Gltf g = square();
    g.more = images(
        2, [&](int i) { return R"({"uri": ")" + (i ? "a.ppm" : inside) + R"("})"; }, true);
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.texture_ids().size(), 1u);
    EXPECT_TRUE(warns(scene, "image is not in the scene's folder"));
}

TEST(RepeatedImages, OfBumpMapsAreDecodedOnce)
{
    const TempFolder folder;
    folder.write("a.ppm", large_image());
    std::string mtl;
    for (int i = 0; i < 50; ++i) mtl += "newmtl m" + std::to_string(i) + "\nmap_Bump a.ppm\n";
    folder.write("m.mtl", mtl);
    const auto file = folder.write("o.obj", std::string("mtllib m.mtl\nusemtl m49\n") + kTriangle + "f 1 2 3\n");
    const std::size_t before = bytes_read();
    const Scene scene = load(file);
    EXPECT_LT(bytes_read() - before, 5 * kMega);
    EXPECT_TRUE(scene.material(only_cage(scene).materials.at(0)).bump_texture);
}

// Returns a glTF whose many buffers are one file, each with a spelling of its own and some bytes more than the one before.
// The positions are in the last buffer.
std::string with_buffers(int count, const std::string& accessor_more)
{
    const auto buffer = [&](int i) {
        return R"({"uri": ")" + spelling(i, "b.bin") + R"(", "byteLength": )" +
               std::to_string(kMega - std::size_t(count - 1 - i)) + "}";
    };
    return R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "buffers": [)" + list_of(count, buffer) +
           R"(], "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": )" + std::to_string(count - 1) +
           R"(, "byteOffset": 999964, "byteLength": 36}], "accessors": [{"componentType": 5126, "type": "VEC3", )" +
           accessor_more + R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]})";
}

TEST(RepeatedBuffers, OfOneFileAreReadOnce)
{
    const TempFolder folder;
    Gltf triangle;
    triangle.put<float>({0, 0, 0, 3, 0, 0, 0, 5, 0});
    folder.write("b.bin", std::string(kMega - 36, '\0') + triangle.bin);
    const auto file = folder.write("a.gltf",
                                   with_buffers(50, R"("bufferView": 1, "count": 3, "min": [0, 0, 0], "max": [3, 5, 0])"));
    const std::size_t before = bytes_read();
    const Scene scene = load(file);
    EXPECT_LT(bytes_read() - before, 2 * kMega);
    EXPECT_EQ(only_cage(scene).positions, (std::vector<Vec3f>{{0, 0, 0}, {3, 0, 0}, {0, 5, 0}}));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(RepeatedBuffers, OfOneFileCountOnceForWhatAccessorsExpandTo)
{
    const TempFolder folder;
    folder.write("b.bin", std::string(kMega, '\0'));
    const auto file = folder.write("a.gltf", with_buffers(50, R"("count": 50000000)"));
    EXPECT_NE(error_of(file).find("accessors expand to far more than the buffers hold"), std::string::npos);
}

TEST(RepeatedBuffers, ThatAreLongerThanTheirFileAreRefused)
{
    const TempFolder folder;
    folder.write("b.bin", std::string(kMega - 1, '\0'));
    EXPECT_NE(error_of(folder.write("a.gltf", with_buffers(2, R"("bufferView": 0, "count": 3)"))), "");
}

TEST(RepeatedFiles, OfMaterialsAreReadOnce)
{
    const TempFolder folder;
    folder.write("m.mtl", "newmtl m\n" + std::string(500'000, '#') + "\n");
    std::string obj;
    for (int i = 0; i < 50; ++i) obj += "mtllib " + spelling(i, "m.mtl") + "\n";
    const auto file = folder.write("o.obj", obj + kTriangle + "usemtl m\nf 1 2 3\n");
    const std::size_t before = bytes_read();
    const Scene scene = load(file);
    EXPECT_LT(bytes_read() - before, kMega);
    EXPECT_EQ(scene.material(only_cage(scene).materials.at(0)).name, "m");
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(RepeatedLists, OfExtensionsAreSearchedOnce)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, )" +
               list_of(200'000, [](int i) { return "\"_" + std::to_string(i) + "\": 0"; }) + R"(}, "indices": 1}]})";
    g.more = R"(, "extensionsUsed": [)" + list_of(200'000, [](int i) { return "\"a" + std::to_string(i) + "\""; }) + "]";
    EXPECT_EQ(cages(load(g.write(folder))).size(), 1u);
}

TEST(RepeatedLists, OfPrimitivesAreSearchedOnceForJoints)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [)" + list_of(3, [](int) { return R"({"attributes": {"POSITION": 0}, "indices": 1})"; }) +
               "]}";
    g.nodes = R"({"mesh": 0, "skin": 0}, {"name": "joint"})";
    g.more = R"(, "skins": [{"joints": [1]}])";
    EXPECT_TRUE(warns(load(g.write(folder)), "skin, but its mesh has no joints (nodes[0])")) << "there are not several";
}

}  // namespace
}  // namespace occam::test
