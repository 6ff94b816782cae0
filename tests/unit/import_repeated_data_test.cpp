// Tests that what a small file names very many times is read once and kept once, or refused.
#include <gtest/gtest.h>

#include <functional>

#include "io/import/copy_budget.h"
#include "tests/support/bytes_read.h"
#include "tests/support/campaign.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

constexpr std::size_t kMega = 1'000'000;
constexpr const char* kCopies = "the file asks for too many copies of what it holds once";
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

// Returns a glTF whose many buffers are one file of two spellings, each with a byte more than the one before. The positions
// are in the last buffer.
std::string with_buffers(int count, const std::string& accessor_more)
{
    const auto buffer = [&](int i) {
        return R"({"uri": ")" + std::string(i % 2 ? "b.bin" : "folder/../b.bin") + R"(", "byteLength": )" +
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
    const auto file = folder.write("a.gltf", with_buffers(50, is_long() ? R"("count": 50000000)" : R"("count": 36000000)"));
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

TEST(RepeatedFiles, OfCagesAreReadOnce)
{
    const TempFolder folder;
    folder.write("c.obj", kQuad + std::string("f 1 2 3 4\n#") + std::string(500'000, '#') + "\n");
    Gltf g;
    g.nodes = list_of(50, [](int i) { return R"({"extras": {"occam": {"cage": ")" + spelling(i, "c.obj") + R"("}}})"; });
    const auto file = g.write(folder);
    const std::size_t before = bytes_read();
    EXPECT_EQ(load(file).counts().cages, 1u);
    EXPECT_LT(bytes_read() - before, kMega);
}

// The first node's style must not show on the others.
TEST(RepeatedFiles, OfCagesInManyStylesAreReadOnce)
{
    const TempFolder folder;
    folder.write("c.obj",
                 kQuad + std::string("vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3 4/3\n#") + std::string(500'000, '#') + "\n");
    folder.write("a.ppm", large_image());
    Gltf g;
    g.nodes = list_of(50, [](int i) {
        std::string style = i == 0 ? R"(, "boundary": "none", "face_varying": "all")" : "";
        if (i < 49) style += R"(, "displacement": {"texture": 0, "scale": )" + std::to_string(i + 1) + "}";
        return R"({"extras": {"occam": {"cage": "c.obj")" + style + "}}}";
    });
    g.more = images(
        1, [](int) { return R"({"uri": "a.ppm"})"; }, true);
    const auto file = g.write(folder);
    const std::size_t before = bytes_read();
    const Scene scene = load(file);
    EXPECT_LT(bytes_read() - before, 2 * kMega);
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 50u);
    EXPECT_EQ(list[0]->boundary, BoundaryRule::None);
    EXPECT_EQ(list[0]->face_varying, FaceVaryingRule::All);
    EXPECT_EQ(list[48]->boundary, BoundaryRule::EdgeAndCorner);
    EXPECT_EQ(list[48]->face_varying, FaceVaryingRule::CornersPlus1);
    ASSERT_TRUE(list[48]->displacement);
    EXPECT_EQ(list[48]->displacement->scale, 49);
    EXPECT_FALSE(list[49]->displacement);
    EXPECT_EQ(list[49]->positions, list[0]->positions);
}

TEST(CopyBudget, LetsCopiesOfLargeThingsBeLarger)
{
    const import::Report report("a.gltf", false);
    import::CopyBudget budget(report);
    constexpr std::size_t kGiga = std::size_t(1) << 30, kMost = ~std::size_t(0);
    budget.charge(kMost, 0, "nodes[0]");
    budget.charge(1, kGiga / 2, "nodes[1]");
    EXPECT_THROW(budget.charge(1, 1, "nodes[2]"), Error);
    budget.allow_copies_of(kGiga);
    budget.charge(16, kGiga, "nodes[3]");
    EXPECT_THROW(budget.charge(1, 1, "nodes[4]"), Error);
    EXPECT_THROW(budget.charge(kMost, kMost, "nodes[5]"), Error);
}

TEST(RepeatedLists, OfWeightsAreNoLongerThanThoseOfTargets)
{
    const TempFolder folder;
    Gltf g = square(R"(, "targets": [{"POSITION": 0}])");
    const std::string weights = R"("weights": [)" + list_of(1000, [](int i) { return std::to_string(i + 1); }) + "]";
    g.meshes.insert(g.meshes.size() - 1, ", " + weights);
    g.nodes = R"({"mesh": 0, )" + weights + "}";
    const Scene scene = load(g.write(folder));
    const Cage& cage = only_cage(scene);
    EXPECT_EQ(cage.morph_weights, std::vector<float>{1});
    EXPECT_EQ(cage.morph_weights.capacity(), 1u);
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        if (node.cages.empty()) return;
        EXPECT_EQ(node.morph_weights, std::vector<float>{1});
        EXPECT_EQ(node.morph_weights.capacity(), 1u);
    });
    EXPECT_TRUE(warns(scene, "needs one weight a morph target"));
}

// Returns a node whose 20,000 instances lie apart from each other.
Gltf instanced(Gltf g, const std::string& node_more)
{
    constexpr int kCount = 20'000;
    const std::size_t offset = g.put<float>({});
    for (int i = 0; i < 3 * kCount; ++i) {
        const auto value = float(10 * i);
        g.bin.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    g.buffer_views.resize(g.buffer_views.rfind(", {"));
    g.buffer_views += R"(, {"buffer": 0, "byteOffset": )" + std::to_string(offset) + R"(, "byteLength": )" +
                      std::to_string(12 * kCount) + "}";
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": )" + std::to_string(kCount) + R"(, "type": "VEC3"})");
    g.nodes = R"({"mesh": 0, )" + node_more +
              R"(, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}})";
    g.more = R"(, "extensionsUsed": ["EXT_mesh_gpu_instancing"])";
    return g;
}

TEST(RepeatedLists, OfInstancesAreRefusedIfTheyAreVeryLong)
{
    const TempFolder folder;
    const std::string targets = list_of(8000, [](int) { return R"({"POSITION": 0})"; });
    const std::string weights = R"("weights": [)" + list_of(8000, [](int) { return std::string("1"); }) + "]";
    const Gltf morphed = instanced(square(R"(, "targets": [)" + targets + "]"), weights);
    EXPECT_NE(error_of(morphed.write(folder)).find(kCopies), std::string::npos);
    const Gltf named = instanced(square(), R"("name": ")" + std::string(30'000, 'a') + "\"");
    EXPECT_NE(error_of(named.write(folder)).find(kCopies), std::string::npos);
    EXPECT_EQ(error_of(instanced(square(), R"("name": "a")").write(folder)), "");
}

TEST(RepeatedLists, OfNodesAreRefusedIfTheyAreVeryLong)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [)" +
               list_of(8000, [](int) { return R"({"attributes": {"POSITION": 0}, "indices": 1})"; }) +
               R"(], "extras": {"occam": {"scheme": "bilinear", "material": 0}}})";
    g.nodes = list_of(20'000, [](int) { return R"({"mesh": 0})"; });
    g.more = R"(, "materials": [{"name": "gold"}])";
    EXPECT_NE(error_of(g.write(folder)).find(kCopies), std::string::npos);
    g.nodes = R"({"mesh": 0}, {"mesh": 0})";
    EXPECT_EQ(error_of(g.write(folder)), "");
}

TEST(RepeatedLists, OfNamesAreRefusedIfTheyAreVeryLong)
{
    const TempFolder folder;
    Gltf g = square();
    const std::string primitive = R"({"attributes": {"POSITION": 0}, "indices": 1})";
    for (const int count : {3, 3000}) {
        g.meshes = R"({"name": ")" + std::string(200'000, 'a') + R"(", "primitives": [)" +
                   list_of(count, [&](int) { return primitive; }) + "]}";
        EXPECT_EQ(error_of(g.write(folder)).find(kCopies) == std::string::npos, count == 3);
    }
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

TEST(RepeatedLists, OfTheExtrasOfAMeshAreReadOnce)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes.insert(g.meshes.size() - 1, R"(, "extras": {"occam": {"boundary": "none", "key": 1, "lit_by": ["a", "a"]}})");
    g.nodes = R"({"mesh": 0}, {"mesh": 0, "extras": {"occam": {"scheme": "bilinear"}}}, {"mesh": 0})";
    const Scene scene = load(g.write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 3u);
    EXPECT_EQ(list[0], list[2]);
    EXPECT_EQ(list[1]->boundary, BoundaryRule::None);
    EXPECT_TRUE(warns(scene, "unknown key 'key' (nodes[0].mesh.extras.occam)")) << "there are not several";
}

TEST(RepeatedLists, OfStringsInExtrasAreNotVeryLong)
{
    const TempFolder folder;
    const auto error_with = [&](const std::string& extras) {
        Gltf g = square();
        g.nodes = R"({"mesh": 0, "extras": {"occam": {)" + extras + "}}}";
        return error_of(g.write(folder));
    };
    const std::string text = "\"" + std::string(5000, 'a') + "\"";
    for (const std::string key : {"cage", "light_group"})
        EXPECT_NE(error_with("\"" + key + "\": " + text).find("longer than 4096 bytes"), std::string::npos) << key;
    EXPECT_NE(error_with("\"lit_by\": [" + text + "]").find("longer than 4096 bytes"), std::string::npos);
    const std::string groups = list_of(33, [](int i) { return "\"" + std::to_string(i) + "\""; });
    EXPECT_NE(error_with("\"lit_by\": [" + groups + "]").find("at most 32 light groups"), std::string::npos);
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
