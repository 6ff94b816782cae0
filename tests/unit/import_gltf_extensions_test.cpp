// Tests of what extensions of glTF do, and that those that are not supported are named.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "io/import/gltf_extensions.h"
#include "tests/support/campaign.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/shared_data.h"

namespace occam::test {
namespace {

std::string used(const std::string& names) { return R"(, "extensionsUsed": [)" + names + "]"; }

const Material& material_of(const Scene& scene, const Cage& cage) { return scene.material(cage.materials.at(0)); }

TEST(GltfExtensions, WhatIsNotUnderstoodIsAWarningByNameAndAnErrorIfStrict)
{
    const TempFolder folder;
    Gltf g = square();
    g.more = used(R"("KHR_materials_sheen", "KHR_materials_iridescence", "KHR_materials_dispersion")");
    const auto file = g.write(folder);
    const Scene scene = load(file);
    EXPECT_EQ(scene.warnings.size(), 2u);
    EXPECT_TRUE(warns(scene, "extension KHR_materials_iridescence is not understood"));
    EXPECT_TRUE(warns(scene, "extension KHR_materials_dispersion is not understood"));
    EXPECT_NE(error_of(file, {.strict = true}).find("KHR_materials_dispersion is not understood"), std::string::npos);
    g.more = used(R"("KHR_materials_sheen", "KHR_materials_anisotropy", "KHR_xmp_json_ld")");
    EXPECT_EQ(error_of(g.write(folder), {.strict = true}), "");
}

TEST(GltfExtensions, TheDocumentedTableIsThatOfTheCode)
{
    std::ostringstream text;
    text << std::ifstream(test::source_folder() / "docs" / "gltf-extensions.md").rdbuf();
    EXPECT_NE(text.str().find(import::gltf_extension_table()), std::string::npos) << "docs/gltf-extensions.md has to hold:\n"
                                                                                  << import::gltf_extension_table();
}

TEST(GltfExtensions, CompressedDataWithoutAnythingElseIsRefusedByName)
{
    const TempFolder folder;
    Gltf draco = square(
        R"(, "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}})");
    draco.more = used(R"("KHR_draco_mesh_compression")");
    EXPECT_EQ(error_of(draco.write(folder)), "");  // The accessors have the data, too.
    draco.accessors.clear();
    draco.accessor(R"({"componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]})");
    draco.accessor(R"({"componentType": 5123, "count": 6, "type": "SCALAR"})");
    EXPECT_NE(error_of(draco.write(folder)).find("KHR_draco_mesh_compression, which is not read"), std::string::npos)
        << error_of(draco.write(folder));

    const auto meshopt = folder.write("meshopt.gltf", R"({"asset": {"version": "2.0"}, "extensionsUsed": [
        "EXT_meshopt_compression"], "buffers": [{"byteLength": 12, "extensions": {"EXT_meshopt_compression": {
        "fallback": true}}}]})");
    EXPECT_NE(error_of(meshopt).find("EXT_meshopt_compression, which is not read (buffers[0])"), std::string::npos)
        << error_of(meshopt);
}

TEST(GltfExtensions, ImagesInDataUrisMayBeOfAnyKind)
{
    const TempFolder folder;
    Gltf g = square(R"(, "material": 0)");
    const auto with = [&](const std::string& uri) {
        g.more = used(R"("EXT_texture_webp")") + R"(, "images": [{"uri": ")" + uri +
                 R"("}], "textures": [{"extensions": {"EXT_texture_webp": {"source": 0}}}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])";
        return load(g.write(folder));
    };
    // Any image will do, for example "P6 1 1 255" with one pixel: only its bytes are kept here.
    const Scene scene = with("data:image/webp;base64,UDYgMSAxIDI1NSD/gAA=");
    const Texture& texture = scene.texture(material_of(scene, *cages(scene).at(0)).base_color_texture.texture);
    ASSERT_TRUE(texture.encoded);
    EXPECT_EQ(texture.encoded->size(), 14u);
    EXPECT_EQ(texture.encoded->front(), std::byte('P'));
    EXPECT_TRUE(warns(with("data:image/webp;base64,"), "image is not in base64 (images[0]"));
    EXPECT_TRUE(warns(with("data:image/webp,P6"), "image is not in base64 (images[0]"));
    EXPECT_TRUE(warns(with("data:"), "image is not in base64 (images[0]"));
}

TEST(GltfExtensions, SpecularGlossinessGoesBeforeMetallicRoughness)
{
    const TempFolder folder;
    folder.write("a.ppm", std::string_view("P6\n1 1\n255\n\xff\x80\0", 14));
    Gltf g = square(R"(, "material": 0)");
    g.more = used(R"("KHR_materials_pbrSpecularGlossiness")") +
             R"(, "images": [{"uri": "a.ppm"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 1, "baseColorFactor": [0, 0, 1, 1]}, "extensions":
        {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0.5, 0.25, 0.75], "specularFactor": [0.5, 0.25, 0.125],
        "glossinessFactor": 0.75, "specularGlossinessTexture": {"index": 0}}}}])";
    const Scene scene = load(g.write(folder));
    const Material& m = material_of(scene, *cages(scene).at(0));
    EXPECT_EQ(m.base_color, Vec4f(1, 0.5f, 0.25f, 0.75f));
    EXPECT_EQ(m.metallic, 0);
    EXPECT_EQ(m.ior, 0);
    EXPECT_EQ(m.specular_color, Vec3f(0.5f, 0.25f, 0.125f));
    EXPECT_EQ(m.roughness, 0.25f);
    EXPECT_TRUE(m.specular_color_texture);
    EXPECT_TRUE(m.glossiness_texture);
    EXPECT_EQ(scene.texture(m.specular_color_texture.texture).role, TextureRole::Color);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(warns(scene, "needs TEXCOORD_0"));
}

TEST(GltfExtensions, SheenAndAnisotropyAreRead)
{
    const TempFolder folder;
    Gltf g = square(R"(, "material": 0)");
    g.more = used(R"("KHR_materials_sheen", "KHR_materials_anisotropy")") + R"(, "materials": [{"extensions": {
        "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.25, 1], "sheenRoughnessFactor": 0.5},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.75, "anisotropyRotation": 1.5}}}])";
    const Scene scene = load(g.write(folder));
    const Material& m = material_of(scene, *cages(scene).at(0));
    EXPECT_EQ(m.sheen_color, Vec3f(0.5f, 0.25f, 1));
    EXPECT_EQ(m.sheen_roughness, 0.5f);
    EXPECT_EQ(m.anisotropy, 0.75f);
    EXPECT_EQ(m.anisotropy_rotation, 1.5f);
}

TEST(GltfExtensions, ACoatsNormalMapHasAScale)
{
    const TempFolder folder;
    Gltf g = square(R"(, "material": 0)");
    g.more = used(R"("KHR_materials_clearcoat")") + R"(, "materials": [{"extensions": {"KHR_materials_clearcoat": {
        "clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 0, "scale": 0.25}}}}], "textures": [{}])";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(material_of(scene, *cages(scene).at(0)).clearcoat_normal_scale, 0.25f);
}

TEST(GltfExtensions, AVariantIsChosenByItsName)
{
    const TempFolder folder;
    Gltf g = square(
        R"(, "material": 0, "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1, 2]}]}})");
    g.more = used(R"("KHR_materials_variants")") +
             R"(, "materials": [{"name": "own"}, {"name": "other"}],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "A"}, {"name": "B"}, {"name": "C"}]}})";
    const auto file = g.write(folder);
    const auto name = [&](const std::string& variant) {
        const Scene scene = load(file, {.variant = variant});
        return material_of(scene, *cages(scene).at(0)).name;
    };
    EXPECT_EQ(load(file).variants, (std::vector<std::string>{"A", "B", "C"}));
    EXPECT_EQ(name(""), "own");
    EXPECT_EQ(name("A"), "own") << "nothing is mapped for it";
    EXPECT_EQ(name("B"), "other");
    EXPECT_EQ(name("C"), "other");
    EXPECT_NE(error_of(file, {.variant = "D"}).find("it has A, B, C"), std::string::npos);
}

Gltf instanced(const std::string& more_attributes = "")
{
    Gltf g = square();
    g.put<float>({0, 0, 0, 5, 0, 0, 0, 7, 0});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"})");
    g.accessor(R"({"componentType": 5126, "count": 2, "type": "VEC3"})");
    g.accessor(R"({"componentType": 5126, "count": 4000000, "type": "VEC3"})");
    g.nodes = R"({"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
        {"TRANSLATION": 2)" +
              more_attributes + "}}}}";
    g.more = used(R"("EXT_mesh_gpu_instancing")");
    return g;
}

TEST(GltfExtensions, InstancesLieBelowTheirNode)
{
    const TempFolder folder;
    const Scene scene = load(instanced().write(folder));
    std::vector<Vec3d> places;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& m) {
        if (!node.cages.empty()) places.push_back(Vec3d(m[3]));
    });
    EXPECT_EQ(places, (std::vector<Vec3d>{{0, 0, 1}, {5, 0, 1}, {0, 7, 1}}));
    EXPECT_EQ(scene.counts().cages, 1u);
}

TEST(GltfExtensions, InstancesThatDoNotFitTogetherOrAreTooManyAreRefused)
{
    const TempFolder folder;
    EXPECT_NE(error_of(instanced(R"(, "SCALE": 3)").write(folder)).find("differ in their number"), std::string::npos);
    EXPECT_NE(error_of(instanced(R"(, "SCALE": 4)").write(folder)).find("at most 1048576 instances"), std::string::npos);
    EXPECT_NE(error_of(instanced(R"(, "ROTATION": 2)").write(folder)).find("wrong type"), std::string::npos);
}

// Writes many instances, which lie `spread` apart along the diagonal.
std::filesystem::path crowded(const TempFolder& folder, int count, float spread)
{
    Gltf g = square();
    g.bin.resize((g.bin.size() + 3) / 4 * 4);
    const std::size_t offset = g.bin.size();
    for (int i = 0; i < 3 * count; ++i) {
        const float value = spread * float(i);
        g.bin.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    g.buffer_views += R"(, {"buffer": 0, "byteOffset": )" + std::to_string(offset) + R"(, "byteLength": )" +
                      std::to_string(12 * count) + "}";
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": )" + std::to_string(count) + R"(, "type": "VEC3"})");
    g.nodes = R"({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}})";
    g.more = used(R"("EXT_mesh_gpu_instancing")");
    return g.write(folder);
}

TEST(GltfExtensions, InstancesInOnePlaceAreOneOrRefused)
{
    const TempFolder folder;
    const int count = is_long() ? 200'000 : 50'000;
    const Scene one = load(crowded(folder, count, 0));
    int placements = 0;
    one.for_each_placement([&](NodeId, const Node& node, const Mat4d&) { placements += !node.cages.empty(); });
    EXPECT_EQ(placements, 1);
    ASSERT_EQ(one.warnings.size(), 1u);
    EXPECT_NE(one.warnings[0].find(std::to_string(count - 1) + " instances are left out"), std::string::npos)
        << one.warnings[0];
    EXPECT_NE(error_of(crowded(folder, count, 1e-9f)).find("overlapping instances"), std::string::npos);
    EXPECT_NO_THROW(load(crowded(folder, count, 1)));
}

}  // namespace
}  // namespace occam::test
