// Tests of the warnings about what a glTF file has and a picture of it cannot show.
#include <gtest/gtest.h>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

/// Returns a square with the sets of texture coordinates that are named, and a material with this text in it.
Gltf textured(const std::vector<int>& sets, const std::string& material)
{
    Gltf g = square();
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})");
    std::string attributes = R"("POSITION": 0)";
    for (const int set : sets) attributes += R"(, "TEXCOORD_)" + std::to_string(set) + R"(": 2)";
    g.meshes = R"({"primitives": [{"attributes": {)" + attributes + R"(}, "indices": 1, "material": 0}]})";
    g.more = R"(, "extensionsUsed": ["KHR_texture_transform", "KHR_materials_clearcoat", "KHR_materials_transmission",
        "KHR_materials_specular", "KHR_materials_sheen", "KHR_materials_volume", "KHR_materials_anisotropy",
        "KHR_materials_pbrSpecularGlossiness"], "images": [{"uri": "data:image/png;base64,UDYgMSAxIDI1NSD/gAA="}],
        "textures": [{"source": 0}], "materials": [{)" +
             material + "}]";
    return g;
}

TEST(GltfRules, SetsOfTextureCoordinatesThatAreUsedAndMissingAreNamed)
{
    const TempFolder folder;
    const auto lacks = [&](const std::vector<int>& sets, const std::string& material) {
        const Scene scene = load(textured(sets, material).write(folder));
        std::string missing;
        for (const std::string& line : scene.warnings)
            if (const std::size_t at = line.find("needs TEXCOORD_"); at != std::string::npos) missing += line[at + 15];
        return missing;
    };
    const auto base = [](const std::string& more) {
        return R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0)" + more + "}}";
    };
    const auto moved = [](int set) {
        return R"(, "extensions": {"KHR_texture_transform": {"texCoord": )" + std::to_string(set) + "}}";
    };
    EXPECT_EQ(lacks({0}, base("")), "");
    EXPECT_EQ(lacks({}, base("")), "0");
    EXPECT_EQ(lacks({0}, base(R"(, "texCoord": 1)")), "1");
    EXPECT_EQ(lacks({0}, base(R"(, "texCoord": 1)" + moved(0))), "") << "the transform's set goes before";
    EXPECT_EQ(lacks({0}, base(moved(1))), "1");
    EXPECT_EQ(lacks({0, 1}, base(moved(1))), "");
    EXPECT_EQ(lacks({0}, base(R"(, "texCoord": 1, "extensions": {"KHR_texture_transform": {"rotation": 1}})")), "1");

    const std::string texture = R"(": {"index": 0, "texCoord": 1}}})";
    for (const char* name : {"clearcoat.clearcoatTexture", "clearcoat.clearcoatNormalTexture",
                             "transmission.transmissionTexture", "specular.specularColorTexture", "sheen.sheenColorTexture",
                             "anisotropy.anisotropyTexture", "pbrSpecularGlossiness.diffuseTexture"}) {
        const std::string both = name;
        const std::size_t dot = both.find('.');
        const std::string material = R"("extensions": {"KHR_materials_)" + both.substr(0, dot) + R"(": {")" +
                                     both.substr(dot + 1) + texture;
        EXPECT_EQ(lacks({0}, material), "1") << name;
        EXPECT_EQ(lacks({0, 1}, material), "") << name;
    }
    EXPECT_EQ(lacks({0}, R"("extensions": {"KHR_materials_volume": {"thicknessTexture)" + texture), "") << "is not read";
    EXPECT_EQ(lacks({0}, base(R"(, "texCoord": 1)") + R"(, "extensions": {"KHR_materials_pbrSpecularGlossiness": {}})"), "")
        << "is not read beside the other";
    EXPECT_EQ(lacks({0}, R"("extras": {"occam": {"bump": {"texture": 0, "texCoord": 1}}})"), "1");
    EXPECT_EQ(lacks({}, R"("extras": {"occam": {"bump": {"texture": 0}}})"), "0");
}

TEST(GltfRules, MaterialsOfVariantsAreCheckedToo)
{
    const TempFolder folder;
    Gltf g = square(R"(, "extensions": {"KHR_materials_variants": {"mappings": [{"material": 0, "variants": [0]}]}})");
    g.more = R"(, "extensionsUsed": ["KHR_materials_variants"], "extensions": {"KHR_materials_variants": {"variants":
        [{"name": "A"}]}}, "images": [{"uri": "data:image/png;base64,UDYgMSAxIDI1NSD/gAA="}], "textures": [{"source": 0}],
        "materials": [{"normalTexture": {"index": 0}}])";
    EXPECT_TRUE(warns(load(g.write(folder)), "needs TEXCOORD_0"));
}

TEST(GltfRules, AnImageOfAnExtensionIsOfTheTypeThatTheExtensionAsksFor)
{
    const TempFolder folder;
    const auto with = [&](const std::string& texture) {
        Gltf g = textured({0}, R"("pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})");
        g.more = R"(, "extensionsUsed": ["EXT_texture_webp"], "images": [{"mimeType": "image/webp", "uri":
            "data:image/webp;base64,UDYgMSAxIDI1NSD/gAA="}], "textures": [{)" +
                 texture + R"(}], "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])";
        return g.write(folder);
    };
    EXPECT_EQ(error_of(with(R"("extensions": {"EXT_texture_webp": {"source": 0}})"), {.strict = true}), "");
    EXPECT_TRUE(warns(load(with(R"("source": 0)")), "mimeType is neither PNG nor JPEG"));
    EXPECT_TRUE(warns(load(with(R"("source": 0, "extensions": {"EXT_texture_webp": {"source": 0}})")),
                      "mimeType is neither PNG nor JPEG"));
}

TEST(GltfRules, NodesBesideWhichTheRestWouldVanishAreLeftOut)
{
    const TempFolder folder;
    const auto shown = [&](const std::string& nodes, const char* warning) {
        Gltf g = square();
        g.nodes = nodes;
        const Scene scene = load(g.write(folder));
        if (!warning) EXPECT_TRUE(scene.warnings.empty()) << nodes;
        else EXPECT_TRUE(warns(scene, warning)) << nodes;
        return cages(scene).size();
    };
    const std::string near = R"({"mesh": 0}, )";
    constexpr const char* kLeftOut = "a node is left out that reaches beyond 1e16";
    EXPECT_EQ(shown(near + R"({"mesh": 0, "translation": [1e25, 0, 0]})", kLeftOut), 1u);
    EXPECT_EQ(shown(near + R"({"mesh": 0, "scale": [1, 1e30, 1]})", kLeftOut), 1u);
    EXPECT_EQ(shown(near + R"({"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,-1e200,1]})", kLeftOut), 1u);
    EXPECT_EQ(
        shown(near + R"({"scale": [1e20, 1e20, 1e20], "children": [2]}, {"mesh": 0, "scale": [1e10, 1, 1]})", kLeftOut), 1u);
    EXPECT_EQ(shown(near + R"({"mesh": 0, "translation": [1e20, 0, 0]})", nullptr), 2u) << "both can be rendered";
    EXPECT_EQ(shown(R"({"mesh": 0, "scale": [1e100, 1e100, 1e100]})", nullptr), 1u) << "there is no rest";
    EXPECT_EQ(
        shown(R"({"mesh": 0, "translation": [1e25, 0, 0], "children": [1]}, {"mesh": 0, "translation": [-1e25, 0, 0]})",
              "the scene vanishes beside a node that reaches beyond 1e16"),
        2u);
}

TEST(GltfRules, NodesWhoseSkinLacksAJointAreCounted)
{
    const TempFolder folder;
    const auto with = [&](std::uint8_t joint) {
        Gltf g = square();
        g.put<std::uint8_t>({0, 0, 0, 0, joint, 9, 0, 0, joint, 0, 0, 0, 0, 0, 0, 0});
        g.put<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
        g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4"})");
        g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"})");
        g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1}]})";
        g.nodes = R"({"mesh": 0, "skin": 0}, {"children": [2, 3]}, {}, {}, {"mesh": 0, "skin": 0}, {"mesh": 0, "skin": 1})";
        g.more = R"(, "skins": [{"joints": [1, 2]}, {"joints": [1, 2, 3]}])";
        return load(g.write(folder));
    };
    EXPECT_TRUE(with(1).warnings.empty()) << "a joint without weight may have any number";
    EXPECT_TRUE(warns(with(2), "a vertex has a joint that its skin lacks (nodes[0], first of 2)")) << "nodes, not corners";
}

TEST(GltfRules, WhatIsLeftOutOfMorphTargetsIsNamed)
{
    const TempFolder folder;
    Gltf g = textured({0}, "");
    g.put<float>({1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1});
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "COLOR_0": 3}, "indices": 1,
        "targets": [{"TEXCOORD_0": 2, "COLOR_0": 3}]}]})";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(warns(scene, "morph targets of TEXCOORD_0 are not read"));
    EXPECT_TRUE(warns(scene, "morph targets of COLOR_0 are not read"));
}

// A last row that is not 0, 0, 0, 1 would move what lies below, and the three others are what the file means.
TEST(GltfRules, MatricesThatAreNotAffineKeepTheirFirstThreeRows)
{
    const TempFolder folder;
    Gltf g = square();
    g.put<float>({2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 5, 6, 7, 0.99999994f});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 1, "type": "MAT4"})");
    g.nodes =
        R"({"children": [1, 2], "matrix": [2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 5, 6, 7, 8]}, {"mesh": 0, "skin": 0}, {})";
    g.more = R"(, "skins": [{"joints": [2], "inverseBindMatrices": 2}])";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(warns(scene, "the matrix is not affine"));
    Mat4d affine(Mat3d(2, 0, 0, 0, 3, 0, 0, 0, 4));
    affine[3] = Vec4d(5, 6, 7, 1);
    int placed = 0;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        if (node.cages.empty()) return;
        ++placed;
        EXPECT_EQ(world_from_node, affine);
        const Mat4d& joint_from_mesh = scene.skin(node.skin).joint_from_mesh.at(0);
        for (int c = 0; c < 4; ++c) EXPECT_LT(glm::distance(joint_from_mesh[c], affine[c]), 1e-6) << c;
    });
    EXPECT_EQ(placed, 1);
}

TEST(GltfRules, ExtensionsAndInstancesThatNothingReadsAreNamed)
{
    const TempFolder folder;
    Gltf g = textured({0}, R"("extensions": {"KHR_materials_iridescence": {"iridescenceFactor": 1}})");
    EXPECT_TRUE(warns(load(g.write(folder)), "extension KHR_materials_iridescence is not understood"));
    g.more.insert(g.more.find("[") + 1, R"("KHR_materials_iridescence", )");
    const Scene declared = load(g.write(folder));
    ASSERT_EQ(declared.warnings.size(), 1u) << "once, though it is declared and used";

    Gltf instances = square();
    instances.nodes = R"({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0, "COLOR": 0,
        "_MINE": 0}}}})";
    instances.more = R"(, "extensionsUsed": ["EXT_mesh_gpu_instancing"])";
    const Scene scene = load(instances.write(folder));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(warns(scene, "unknown attribute 'COLOR'"));
}

}  // namespace
}  // namespace occam::test
