// Tests of vertex data of glTF in all its forms, and of what extras.occam adds to a cage.
#include <gtest/gtest.h>

#include <glm/matrix.hpp>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

// By KHR_mesh_quantization, positions of 16 bits are taken as they are, and normals of 8 bits are normalised. The node
// scales them back.
TEST(ImportGltfGeometry, QuantizedPositionsAreNumbersAndQuantizedNormalsAreNormalized)
{
    const TempFolder folder;
    Gltf g;
    g.put<std::int16_t>({0, 0, 0, 0, 1000, 0, 0, 0, 0, -500, 0, 0});
    g.put<std::int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, -127, 0});
    g.buffer_views = R"({"buffer": 0, "byteLength": 24, "byteStride": 8},
        {"buffer": 0, "byteOffset": 24, "byteLength": 12, "byteStride": 4})";
    g.accessor(
        R"({"bufferView": 0, "componentType": 5122, "count": 3, "type": "VEC3", "min": [0, -500, 0], "max": [1000, 0, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]})";
    g.nodes = R"({"mesh": 0, "scale": [0.001, 0.001, 0.001]})";
    g.more = R"(, "extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"])";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    const Cage& cage = *cages(scene).at(0);
    EXPECT_EQ(cage.positions, (std::vector<Vec3f>{{0, 0, 0}, {1000, 0, 0}, {0, -500, 0}}));
    EXPECT_EQ(cage.normals, (std::vector<Vec3f>{{0, 0, 1}, {0, 0, 1}, {0, 0, -1}}));
}

TEST(ImportGltfGeometry, VertexColoursOfThreeComponentsAreOpaque)
{
    const TempFolder folder;
    Gltf g = square();
    g.put<std::uint8_t>({255, 0, 51, 0, 0, 255, 0, 0, 0, 0, 255, 0, 255, 255, 255, 0});
    g.buffer_views += R"(, {"buffer": 0, "byteOffset": 60, "byteLength": 16, "byteStride": 4})";
    g.put<std::uint16_t>({65535, 0, 13107, 32896, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 65535});
    g.accessor(R"({"bufferView": 3, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC3"})");
    g.accessor(R"({"bufferView": 4, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC4"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1},
        {"attributes": {"POSITION": 0, "COLOR_0": 3}, "indices": 1}]})";
    const Scene scene = load(g.write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]->colors, (std::vector<Vec4f>{{1, 0, 0.2f, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 1, 1}}));
    EXPECT_EQ(list[1]->colors.at(0), Vec4f(1, 0, 0.2f, 32896 / 65535.0f));
    EXPECT_EQ(list[1]->colors.at(3), Vec4f(0, 0, 0, 1));
}

TEST(ImportGltfGeometry, TheSecondUvSetKeepsItsNumberWithoutAFirst)
{
    const TempFolder folder;
    Gltf g = square();
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1});
    g.put<float>({0, 0, 2, 0, 2, 2, 0, 2});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC2"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "TEXCOORD_1": 3}, "indices": 1},
        {"attributes": {"POSITION": 0, "TEXCOORD_1": 3}, "indices": 1}]})";
    const Scene scene = load(g.write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 2u);
    for (const Cage* cage : list) {
        ASSERT_EQ(cage->uv_sets.size(), 2u);
        EXPECT_EQ(cage->uv_sets[1].values.at(2), Vec2f(2, 2));
    }
    EXPECT_EQ(list[0]->uv_sets[0].values.at(2), Vec2f(1, 1));
    EXPECT_EQ(list[1]->uv_sets[0].values.at(2), Vec2f(0, 0));
}

TEST(ImportGltfGeometry, BuffersAndImagesMayBeDataUris)
{
    const TempFolder folder;
    // The buffer holds three corners of a triangle in base64. Any image will do, for example a PPM: only its bytes are kept
    // here.
    const auto file = folder.write("data.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "buffers": [{"byteLength": 36, 
           "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "textures": [{"source": 0}],
        "images": [{"uri": "data:image/png;base64,iVBORw0KGgo="}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 0]}]})");
    const Scene scene = load(file);
    const Cage& cage = *cages(scene).at(0);
    EXPECT_EQ(cage.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    const Texture& image = scene.texture(scene.material(cage.materials.at(0)).base_color_texture.texture);
    ASSERT_TRUE(image.encoded);
    EXPECT_EQ(image.encoded->size(), 8u);
}

TEST(ImportGltfGeometry, MirroredNodesKeepTheirMatrix)
{
    const TempFolder folder;
    Gltf g = square();
    g.nodes =
        R"({"scale": [-1, 2, 3], "children": [1]}, {"mesh": 0, "scale": [1, -1, 1]}, {"mesh": 0, "scale": [1, 1, -1]})";
    g.more = R"(, "scenes": [{"nodes": [0, 2]}], "scene": 0)";
    const Scene scene = load(g.write(folder));
    std::vector<double> determinants;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world) {
        if (!node.cages.empty()) determinants.push_back(glm::determinant(world));
    });
    EXPECT_EQ(determinants, (std::vector<double>{6, -1}));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(ImportGltfGeometry, DisplacementReachesTheCageWithABound)
{
    const TempFolder folder;
    folder.write("h.png", "");
    Gltf g = square();
    g.more = R"(, "images": [{"uri": "h.png"}], "textures": [{"source": 0}])";
    const auto with = [&](const std::string& displacement) {
        g.nodes = R"({"mesh": 0, "extras": {"occam": {"scheme": "catmull-clark", "displacement": )" + displacement + "}}}";
        return g.write(folder);
    };
    const Scene scene = load(with(R"({"texture": 0, "scale": -2, "midlevel": 0.25})"));
    ASSERT_TRUE(cages(scene).at(0)->displacement);
    const Displacement d = *cages(scene).at(0)->displacement;
    EXPECT_EQ(scene.texture(d.texture.texture).path.filename(), "h.png");
    EXPECT_EQ(scene.texture(d.texture.texture).role, TextureRole::Data);
    EXPECT_EQ(d.scale, -2);
    EXPECT_EQ(d.midlevel, 0.25f);
    EXPECT_EQ(d.bound, 1.5f) << "a texel of 1 moves by 0.75 times the scale";
    EXPECT_EQ(cages(load(with(R"({"texture": 0, "bound": 0.125})"))).at(0)->displacement->bound, 0.125f);
    EXPECT_EQ(d.space, Displacement::Space::Normal);
    const Scene by_vectors = load(with(R"({"texture": 0, "scale": 2, "axes": "object"})"));
    EXPECT_EQ(cages(by_vectors).at(0)->displacement->space, Displacement::Space::Object);
    EXPECT_NEAR(cages(by_vectors).at(0)->displacement->bound, std::sqrt(3.0f), 1e-6f)
        << "three channels of a half times the scale";
    const Scene by_tangents = load(with(R"({"texture": 0, "scale": 2, "axes": "tangent"})"));
    EXPECT_EQ(cages(by_tangents).at(0)->displacement->space, Displacement::Space::Tangent);
    EXPECT_NEAR(cages(by_tangents).at(0)->displacement->bound, std::sqrt(3.0f), 1e-6f);
    EXPECT_NE(error_of(with(R"({"texture": 0, "axes": "world"})")).find("normal, object, tangent"), std::string::npos);
    EXPECT_NE(error_of(with(R"({"texture": 1})")).find("no texture 1"), std::string::npos);
    EXPECT_NE(error_of(with(R"({"scale": 1})")).find("texture is missing"), std::string::npos);
    EXPECT_NE(error_of(with(R"({"texture": 0, "bound": -1})")).find("must not be negative"), std::string::npos);
    EXPECT_TRUE(warns(load(with(R"({"texture": 0, "height": 1})")), "unknown key 'height'"));
    EXPECT_TRUE(warns(scene, "lacks the texture coordinates"));
    g.nodes = R"({"mesh": 0, "extras": {"occam": {"displacement": {"texture": 0}}}})";
    EXPECT_TRUE(warns(load(g.write(folder)), "it is a mesh of triangles"));
}

TEST(ImportGltfGeometry, BumpMapsAreExtrasOfMaterials)
{
    const TempFolder folder;
    folder.write("h.png", "");
    const auto with = [&](const std::string& bump) {
        Gltf g = square();
        g.more =
            R"(, "images": [{"uri": "h.png"}], "textures": [{"source": 0}],
                "materials": [{"name": "rough", "extras": {"occam": {"bump": )" +
            bump + "}}}]";
        g.meshes.insert(g.meshes.find("\"attributes\""), R"("material": 0, )");
        return g.write(folder);
    };
    const Scene scene = load(with(R"({"texture": 0, "scale": -0.5, "texCoord": 1})"));
    const Material m = scene.material(cages(scene).at(0)->materials.at(0));
    ASSERT_TRUE(m.bump_texture);
    EXPECT_EQ(scene.texture(m.bump_texture.texture).role, TextureRole::Data);
    EXPECT_EQ(m.bump_scale, -0.5f);
    EXPECT_EQ(m.bump_texture.uv_set, 1);
    EXPECT_NE(error_of(with(R"({"texture": 1})")).find("no texture 1 (materials[0] 'rough'"), std::string::npos)
        << error_of(with(R"({"texture": 1})"));
    EXPECT_NE(error_of(with(R"({"scale": 1})")).find("texture is missing"), std::string::npos);
    EXPECT_NE(error_of(with(R"({"texture": 0, "scale": "high"})")).find("scale must be a number"), std::string::npos);
    EXPECT_TRUE(warns(load(with(R"({"texture": 0, "height": 1})")), "unknown key 'height'"));
    EXPECT_TRUE(warns(load(with(R"({"texture": 0, "texCoord": 7})")), "TEXCOORD_0 and TEXCOORD_1"));
}

// What an accessor does not hold is zero (glTF 2.0, sec. 3.6.2.3): in the fourth component, too.
TEST(ImportGltfGeometry, ElementsThatAnAccessorLeavesOutAreZero)
{
    const TempFolder folder;
    Gltf g = square();
    g.put<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    g.put<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.1875f, 0, 0, 0, 1, 0, 0, 0});
    g.put<std::uint8_t>({2});
    g.put<float>({0.125f, 0.25f, 0.0625f, 0.375f});
    g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"})");
    g.accessor(R"({"componentType": 5126, "count": 4, "type": "VEC4", "sparse": {"count": 1,
        "indices": {"bufferView": 4, "componentType": 5121}, "values": {"bufferView": 5}}})");
    g.accessor(R"({"componentType": 5126, "count": 4, "type": "VEC4"})");
    g.meshes =
        R"({"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3, "JOINTS_1": 2, "WEIGHTS_1": 4,
            "COLOR_0": 4}, "indices": 1}, {"attributes": {"POSITION": 0, "COLOR_0": 5}, "indices": 1}]})";
    const Vec4f given(0.125f, 0.25f, 0.0625f, 0.375f);
    const std::vector<Vec4f> expected = {Vec4f(0), Vec4f(0), given, Vec4f(0)};
    const Scene scene = load(g.write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]->colors, expected);
    ASSERT_EQ(list[0]->skin.sets, 2);
    EXPECT_EQ(std::vector<Vec4f>(list[0]->skin.weights.begin() + 4, list[0]->skin.weights.end()), expected);
    EXPECT_EQ(list[1]->colors, std::vector<Vec4f>(4, Vec4f(0)));
}

TEST(ImportGltfGeometry, IndicesMayBeSparseAndNothingElse)
{
    const TempFolder folder;
    Gltf g = square();
    g.put<std::uint8_t>({1, 2, 4, 5});
    g.put<std::uint16_t>({1, 2, 2, 3});
    g.accessor(R"({"componentType": 5123, "count": 6, "type": "SCALAR", "sparse": {"count": 4,
        "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}}})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]})";
    const auto file = g.write(folder);
    EXPECT_EQ(error_of(file, {.strict = true}), "");
    EXPECT_EQ(cages(load(file)).at(0)->face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));

    // All of these are 0.
    g.accessor(R"({"componentType": 5123, "count": 6, "type": "SCALAR"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "<indices>": 2}, "indices": 3}]})";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(cages(scene).at(0)->face_vertices.empty());
    EXPECT_FALSE(scene.warnings.empty());

    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "<indices>": 2}}]})";
    EXPECT_EQ(cages(load(g.write(folder))).at(0)->face_vertices, (std::vector<std::uint32_t>{0, 1, 2}))
        << "an attribute of that name is none of ours";
}

}  // namespace
}  // namespace occam::test
