#include <gtest/gtest.h>

#include "scenegraph/content_rules.h"
#include "tests/support/campaign.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

TEST(ImportGltf, ReadsTrianglesFromAFileBesideIt)
{
    const TempFolder folder;
    const Scene scene = load(square().write(folder));
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 1u);
    EXPECT_EQ(list[0]->scheme, Scheme::Triangles);
    EXPECT_EQ(list[0]->positions[2], Vec3f(1, 1, 0));
    EXPECT_EQ(list[0]->face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
}

TEST(ImportGltf, StripsAndFansWindLikeTheirFirstTriangle)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}, {"attributes": {"POSITION": 0}, "mode": 6}]})";
    const Scene scene = load(g.write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]->face_vertices, (std::vector<std::uint32_t>{0, 1, 2, 1, 3, 2}));
    EXPECT_EQ(list[1]->face_vertices, (std::vector<std::uint32_t>{1, 2, 0, 2, 3, 0}));
}

TEST(ImportGltf, PointsAndLinesAreCountedAndLeftOut)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}, {"attributes": {"POSITION": 0}, "mode": 3}]})";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(cages(scene).empty());
    EXPECT_TRUE(warns(scene, "points and lines are not rendered"));
    EXPECT_TRUE(warns(scene, "first of 2"));
}

TEST(ImportGltf, ReadsInterleavedNormalizedAndSparseAccessors)
{
    const TempFolder folder;
    Gltf g;
    // The buffer holds three vertices of 16 bytes, each with a position and a texture coordinate in normalised bytes.
    g.put<std::uint8_t>({0, 0, 0, 0, 0, 0,   0, 0, 0, 0, 0, 0, 255, 51, 0,   0,  0, 0, 128, 63, 0, 0, 0, 0,
                         0, 0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0,   0,  128, 63, 0, 0, 0,   0,  0, 0, 0, 0});
    g.buffer_views.insert(g.buffer_views.size() - 1, R"(, "byteStride": 16)");
    g.put<std::uint8_t>({2});
    g.put<float>({5, 6, 7});
    g.accessor(R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [5, 6, 7],
                   "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
                "values": {"bufferView": 2}}})");
    g.accessor(
        R"({"bufferView": 0, "byteOffset": 12, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"})");
    g.accessor(R"({"componentType": 5126, "count": 3, "type": "VEC3"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 2}}]})";
    g.nodes = R"({"mesh": 0})";
    const Scene scene = load(g.write(folder));
    const Cage& cage = *cages(scene).at(0);
    EXPECT_EQ(cage.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {5, 6, 7}}));
    EXPECT_EQ(cage.uv_sets.at(0).values[0], Vec2f(1, 0.2f));
    EXPECT_EQ(cage.uv_sets.at(0).values[1], Vec2f(0, 1));
    EXPECT_TRUE(warns(scene, "normals had no direction")) << "an accessor without a view is zero";
}

TEST(ImportGltf, AccessorsThatDoNotFitAreRefusedByName)
{
    const TempFolder folder;
    const auto broken = [&](const std::string& from, const std::string& to) {
        Gltf g = square();
        const auto replace = [&](std::string& text) {
            if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
        };
        replace(g.accessors), replace(g.buffer_views), replace(g.meshes);
        return error_of(g.write(folder));
    };
    EXPECT_EQ(broken("nothing", ""), "");
    EXPECT_NE(broken(R"("count": 4)", R"("count": 5)").find("does not fit its buffer view (accessors[0])"),
              std::string::npos);
    EXPECT_NE(broken(R"("count": 4)", R"("count": 4294967295)").find("accessors[0]"), std::string::npos);
    EXPECT_NE(broken(R"("count": 4)", R"("count": 1e300)").find("accessors[0].count"), std::string::npos);
    EXPECT_NE(broken(R"("bufferView": 0)", R"("bufferView": 0, "byteOffset": 9007199254740992)").find("accessors[0]"),
              std::string::npos);
    EXPECT_NE(broken(R"("byteLength": 48)", R"("byteLength": 4096)").find("bufferViews[0]"), std::string::npos);
    EXPECT_NE(broken(R"("byteLength": 48)", R"("byteLength": 48, "byteStride": 4)").find("stride"), std::string::npos);
    EXPECT_NE(broken(R"("bufferView": 1)", R"("bufferView": 2)").find("accessors[1].bufferView"), std::string::npos);
    EXPECT_NE(broken(R"("componentType": 5123, "count": 6)", R"("componentType": 5126, "count": 3)").find("unsigned"),
              std::string::npos);
    EXPECT_NE(broken(R"("POSITION": 0)", R"("POSITION": 7)").find("attributes.POSITION"), std::string::npos);
    EXPECT_NE(broken(R"("indices": 1)", R"("indices": -1)").find("indices"), std::string::npos);
    EXPECT_NE(broken(R"("VEC3")", R"("VEC9")").find("accessors[0].type"), std::string::npos);
}

// The library would take such numbers for others, or for none (JSON of glTF has integers without a fraction).
TEST(ImportGltf, IntegersWithAPointAreRefusedByName)
{
    const TempFolder folder;
    const auto with = [&](const char* key, const char* number) {
        Gltf g = square();
        std::string& text = std::string_view(key) == "mode" ? g.meshes : g.accessors;
        text.insert(text.find('{', std::string_view(key) == "mode" ? 1 : 0) + 1,
                    "\"" + std::string(key) + "\": " + number + ", ");
        return error_of(g.write(folder));
    };
    EXPECT_EQ(with("byteOffset", "0"), "");
    EXPECT_NE(with("byteOffset", "12.0").find("must be an integer without a point, not 12.0 (accessors[0].byteOffset)"),
              std::string::npos);
    EXPECT_NE(with("byteOffset", "0.5").find("must be an integer without a point, not 0.5"), std::string::npos);
    EXPECT_NE(with("byteOffset", "0.0").find("not 0.0 (accessors[0].byteOffset)"), std::string::npos);
    EXPECT_EQ(with("mode", "4"), "");
    EXPECT_NE(with("mode", "0.0").find("not 0.0 (meshes[0].primitives[0].mode)"), std::string::npos) << "no triangles";
    EXPECT_NE(with("mode", "5.0").find("not 5.0 (meshes[0].primitives[0].mode)"), std::string::npos);
}

TEST(ImportGltf, ManyAccessorsOfTheSameBytesDoNotEatMemory)
{
    const TempFolder folder;
    Gltf g = square();
    g.accessors.clear(), g.meshes.clear();
    std::string primitives;
    const std::string count = is_long() ? "100000000" : "1500000";
    for (int i = 0; i < 40; ++i) {
        g.accessor(R"({"componentType": 5126, "count": )" + count + R"(, "type": "VEC3"})");
        primitives += (i ? ", " : "") + std::string(R"({"attributes": {"POSITION": )") + std::to_string(i) + "}}";
    }
    g.meshes = R"({"primitives": [)" + primitives + "]}";
    EXPECT_NE(error_of(g.write(folder)).find("far more than the buffers hold"), std::string::npos);
}

TEST(ImportGltf, NodesHaveMatricesOrParts)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"name": "a", "translation": [1, 2, 3], "scale": [2, 2, 2], "children": [1]},
                 {"name": "b", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1]})";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(Vec3d(scene.world_from_node(scene.find_node("b"))[3]), Vec3d(21, 2, 3));
}

TEST(ImportGltf, TreesThatAreNoneAreRefused)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"children": [1]}, {"children": [0]})";
    EXPECT_NE(error_of(g.write(folder)).find("own ancestor"), std::string::npos);
    g.nodes = R"({"children": [2]}, {"children": [2]}, {})";
    EXPECT_NE(error_of(g.write(folder)).find("two parents (nodes[2])"), std::string::npos);
    g.nodes = R"({"children": [0]})";
    EXPECT_NE(error_of(g.write(folder)), "");
    g.nodes = "{}";
    for (int i = 1; i < 6000; ++i) g.nodes += R"(, {"children": [)" + std::to_string(i - 1) + "]}";
    EXPECT_NE(error_of(g.write(folder)).find("deeper than 4096"), std::string::npos);
    g.nodes = std::string(100'000, '[');
    EXPECT_NE(error_of(g.write(folder)).find("nested deeper"), std::string::npos);
}

TEST(ImportGltf, UnknownRequiredExtensionsAreRefusedByName)
{
    const TempFolder folder;
    Gltf g = square();
    g.more = R"(, "extensionsUsed": ["KHR_draco_mesh_compression"], "extensionsRequired": ["KHR_draco_mesh_compression"])";
    EXPECT_NE(error_of(g.write(folder)).find("KHR_draco_mesh_compression"), std::string::npos);
    g.more = R"(, "extensionsUsed": ["KHR_draco_mesh_compression"])";
    EXPECT_EQ(error_of(g.write(folder)), "") << "optional ones are not needed";
    g.asset = R"({"version": "1.0"})";
    EXPECT_NE(error_of(g.write(folder)).find("only glTF 2"), std::string::npos);
    g.asset = R"({"version": "2.0", "minVersion": "2.1"})";
    EXPECT_NE(error_of(g.write(folder)).find("2.1"), std::string::npos);
}

TEST(ImportGltf, AnglesOfCamerasAreWithinWhatCanBeSeen)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"camera": 0}, {"camera": 1})";
    g.more = R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 1e-9, "znear": 0.1}},
                              {"type": "perspective", "perspective": {"yfov": 9, "znear": 0.1}}])";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.warnings.size(), 2u);
    for (const std::string& name : scene.camera_names()) EXPECT_NO_THROW(check(*scene.camera(name))) << name;
}

TEST(ImportGltf, ReadsCamerasAndPunctualLights)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"name": "eye", "camera": 0}, {"camera": 1}, {"extensions": {"KHR_lights_punctual": {"light": 0}}},
                 {"extensions": {"KHR_lights_punctual": {"light": 1}}})";
    g.more = R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 2, "znear": 0.1}},
                              {"type": "orthographic", "name": "flat", "orthographic": {"xmag": 3, "ymag": 2,
                "znear": 0, "zfar": 9}}],
                "extensionsUsed": ["KHR_lights_punctual"],
                "extensions": {"KHR_lights_punctual": {"lights": [
                    {"type": "spot", "intensity": 10, "color": [1, 0.5, 0], "range": 7, "spot": {"outerConeAngle": 0.4}},
                    {"type": "directional", "intensity": 3}]}})";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.camera_names(), (std::vector<std::string>{"eye", "flat"}));
    EXPECT_EQ(scene.camera("eye")->lens.fov, 0.5f);
    EXPECT_EQ(scene.camera("eye")->lens.aspect, 2);
    EXPECT_TRUE(scene.camera("flat")->lens.orthographic);
    EXPECT_EQ(scene.camera("flat")->lens.height, 4);
    EXPECT_EQ(scene.camera("flat")->lens.aspect, 1.5f);
    std::vector<const Light*> lights;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        if (const Light* light = scene.find(node.light)) lights.push_back(light);
    });
    ASSERT_EQ(lights.size(), 2u);
    const auto& spot = std::get<PointLight>(lights[0]->kind);
    EXPECT_EQ(spot.intensity, Vec3f(10, 5, 0));
    EXPECT_EQ(spot.range, 7);
    EXPECT_EQ(spot.outer_angle, 0.4f);
    EXPECT_EQ(std::get<SunLight>(lights[1]->kind).irradiance, Vec3f(3));
}

// A small file may name one large image thousands of times.
TEST(ImportGltf, ImagesFromOnePlaceAreOneTexture)
{
    const TempFolder folder;
    folder.write("a.png", "");
    folder.write("b.png", "");
    Gltf g = square(R"(, "material": 0)");
    g.more = R"(, "images": [{"uri": "a.png"}, {"uri": "b.png"}, {"uri": "a.png"}],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}],
        "materials": [{"emissiveTexture": {"index": 0}}, {"emissiveTexture": {"index": 1}},
                {"emissiveTexture": {"index": 2}}])";
    EXPECT_EQ(load(g.write(folder)).texture_ids().size(), 2u);
}

TEST(ImportGltf, ReadsEveryPartOfAMaterial)
{
    const TempFolder folder;
    folder.write("a.png", "");
    Gltf g = square(R"(, "material": 0)");
    g.more = R"(, "images": [{"uri": "a.png"}], "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}],
        "textures": [{"source": 0, "sampler": 0}],
        "extensionsUsed": ["KHR_texture_transform", "KHR_materials_ior", "KHR_materials_unlit"],
        "materials": [{"name": "m", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
                "emissiveFactor": [1, 0.5, 0],
          "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 0.75], "roughnessFactor": 0.125,
            "baseColorTexture": {"index": 0, "texCoord": 1,
                "extensions": {"KHR_texture_transform": {"offset": [0.5, 1], "scale": [2, 3], "rotation": 1,
                "texCoord": 0}}},
            "metallicRoughnessTexture": {"index": 0}},
          "normalTexture": {"index": 0, "scale": 2}, "occlusionTexture": {"index": 0, "strength": 0.5},
          "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4},
                "KHR_materials_ior": {"ior": 1.25}, "KHR_materials_unlit": {},
            "KHR_materials_transmission": {"transmissionFactor": 0.5},
                "KHR_materials_clearcoat": {"clearcoatFactor": 0.25, "clearcoatTexture": {"index": 0}},
            "KHR_materials_specular": {"specularFactor": 0.75, "specularColorFactor": [1, 2, 3]}}}])";
    const Scene scene = load(g.write(folder));
    const Material& m = scene.material(cages(scene).at(0)->materials.at(0));
    EXPECT_EQ(m.base_color, Vec4f(0.5f, 0.25f, 1, 0.75f));
    EXPECT_EQ(m.metallic, 1) << "the default of glTF";
    EXPECT_EQ(m.roughness, 0.125f);
    EXPECT_EQ(m.emission, Vec3f(4, 2, 0));
    EXPECT_EQ(m.alpha_mode, AlphaMode::Mask);
    EXPECT_EQ(m.alpha_cutoff, 0.25f);
    EXPECT_TRUE(m.double_sided && m.unlit);
    EXPECT_EQ(m.ior, 1.25f);
    EXPECT_EQ(m.transmission, 0.5f);
    EXPECT_EQ(m.clearcoat, 0.25f);
    EXPECT_TRUE(m.clearcoat_texture);
    EXPECT_EQ(m.specular, 0.75f);
    EXPECT_EQ(m.specular_color, Vec3f(1, 2, 3));
    EXPECT_EQ(m.normal_scale, 2);
    EXPECT_EQ(m.occlusion_strength, 0.5f);
    const TextureUse& use = m.base_color_texture;
    EXPECT_EQ(use.uv_set, 0) << "the extension's set goes first";
    EXPECT_EQ(use.offset, Vec2f(0.5f, 1));
    EXPECT_EQ(use.scale, Vec2f(2, 3));
    EXPECT_EQ(use.rotation, 1);
    EXPECT_EQ(use.wrap_s, TextureUse::Wrap::Clamp);
    EXPECT_EQ(use.wrap_t, TextureUse::Wrap::Mirror);
    EXPECT_TRUE(use.nearest);
    EXPECT_EQ(scene.texture(use.texture).role, TextureRole::Color);
    EXPECT_EQ(scene.texture(m.normal_texture.texture).role, TextureRole::Data);
    EXPECT_EQ(scene.counts().textures, 2u) << "one for each role, however many use it";
}

// The default material is one without any property (glTF 2.0, sec. 3.9.6): a rough metal.
TEST(ImportGltf, APrimitiveWithoutAMaterialHasTheDefaultOne)
{
    const TempFolder folder;
    Gltf g = square();
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
        {"attributes": {"POSITION": 0}, "indices": 1, "material": 0}, {"attributes": {"POSITION": 0}, "indices": 1}]})";
    g.more = R"(, "materials": [{}])";
    for (const Subdivide subdivide : {Subdivide::Off, Subdivide::On}) {
        const Scene scene = load(g.write(folder), {.subdivide = subdivide});
        std::vector<MaterialId> used;
        for (const Cage* cage : cages(scene)) used.insert(used.end(), cage->materials.begin(), cage->materials.end());
        ASSERT_EQ(used.size(), 3u);
        for (const MaterialId id : used) {
            const Material& material = scene.material(id);
            EXPECT_EQ(material.metallic, 1.0f);
            EXPECT_EQ(material.roughness, 1.0f);
            EXPECT_EQ(material.base_color, Vec4f(1));
        }
        EXPECT_EQ(used[0], used[2]);
    }
}

TEST(ImportGltf, ImagesStayInTheFolderAndMissingOnesAreCounted)
{
    const TempFolder folder;
    folder.write("secret.png", "");
    Gltf g = square();
    g.more =
        R"(, "images": [{"uri": "../secret.png"}, {"uri": "missing%20one.png"}], "textures": [{"source": 0}, {"source": 1}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
                {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}])";
    folder.write("scene/data file.bin", g.bin);
    const auto file = folder.write("scene/s.gltf", g.json());
    const Scene scene = load(file);
    EXPECT_TRUE(warns(scene, "image is not in the scene's folder"));
    EXPECT_TRUE(warns(scene, "image file is missing (missing%20one.png)"));
    EXPECT_EQ(scene.counts().textures, 0u);
    EXPECT_NE(error_of(file, {.strict = true}), "");
}

TEST(ImportGltf, BuffersStayInTheFolder)
{
    const TempFolder folder;
    Gltf g = square();
    folder.write("data file.bin", g.bin);
    std::string json = g.json();
    const std::string name = "data%20file.bin";
    json.replace(json.find(name), name.size(), "../" + name);
    EXPECT_NE(error_of(folder.write("scene/s.gltf", json)), "");
}

TEST(ImportGltf, SkinsMorphTargetsAndClipsReachTheDataModel)
{
    const TempFolder folder;
    Gltf g = square(R"(, "targets": [{"POSITION": 0}])");
    g.meshes.insert(g.meshes.size() - 1, R"(, "weights": [0.5])");
    g.meshes.replace(g.meshes.find(R"("POSITION": 0)"), 13, R"("POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3)");
    g.put<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
    g.put<float>({0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0});
    g.put<float>({0, 1});
    g.put<float>({0, 0, 0, 1, 2, 3});
    g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"})");
    g.accessor(R"({"bufferView": 4, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]})");
    g.accessor(R"({"bufferView": 5, "componentType": 5126, "count": 2, "type": "VEC3"})");
    g.nodes = R"({"mesh": 0, "skin": 0}, {"name": "hip", "children": [2]}, {"name": "knee"})";
    g.more = R"(, "skins": [{"joints": [1, 2]}],
        "animations": [{"name": "walk", "samplers": [{"input": 4, "output": 5, "interpolation": "STEP"}],
                        "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}},
                                     {"sampler": 0, "target": {"node": 1, "path": "rotation"}}]}])";
    const Scene scene = load(g.write(folder));
    const Cage& cage = *cages(scene).at(0);
    EXPECT_EQ(cage.skin.sets, 1);
    EXPECT_EQ(cage.skin.joints[0], glm::u16vec4(0, 1, 0, 0));
    ASSERT_EQ(cage.morph_targets.size(), 1u);
    EXPECT_EQ(cage.morph_weights, std::vector<float>{0.5f});
    ASSERT_EQ(scene.clips().size(), 1u);
    const Clip& clip = scene.clip(scene.clips()[0]);
    ASSERT_EQ(clip.channels.size(), 1u) << "a rotation needs four numbers a key";
    EXPECT_TRUE(warns(scene, "animation channel dropped"));
    EXPECT_EQ(clip.channels[0].target, scene.find_node("knee"));
    EXPECT_EQ(clip.channels[0].interpolation, Channel::Interpolation::Step);
    EXPECT_EQ(clip.channels[0].values.size(), 6u);
    bool has_skin = false;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) { has_skin |= bool(node.skin); });
    EXPECT_TRUE(has_skin);
}

TEST(ImportGltf, AMorphWeightThatNoFloatHoldsIsNone)
{
    const TempFolder folder;
    Gltf g = square(R"(, "targets": [{"POSITION": 0}])");
    g.nodes = R"({"name": "face", "mesh": 0, "weights": [1e39]})";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.node(scene.find_node("face")).morph_weights, std::vector<float>{0});
    EXPECT_TRUE(warns(scene, "a morph weight is not finite"));
}

}  // namespace
}  // namespace occam::test
