// Tests of what glTF files say in their extras: cages, area lights and the environment.
#include <gtest/gtest.h>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

// Two quads share an edge, are split along it as glTF splits seams, and are each a fan of two triangles.
TEST(ImportGltf, PolygonsComeBackWhenACageIsWanted)
{
    const TempFolder folder;
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, /**/ 1, 0, 0, 2, 0, 0, 2, 1, 0, 1, 1, 0});
    g.put<std::uint16_t>({0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1});
    g.accessor(
        R"({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [2, 1, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"})");
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC2"})");
    g.meshes =
        R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1,
                "extensions": {"FB_ngon_encoding": {}}}]})";
    g.nodes = R"({"mesh": 0})";
    g.more = R"(, "extensionsUsed": ["FB_ngon_encoding"])";
    const auto file = g.write(folder);
    EXPECT_EQ(cages(load(file)).at(0)->scheme, Scheme::Triangles) << "as the file says";
    const Scene scene = load(file, {.subdivide = Subdivide::On});
    const Cage& cage = *cages(scene).at(0);
    EXPECT_EQ(cage.scheme, Scheme::CatmullClark);
    EXPECT_EQ(cage.face_sizes, (std::vector<std::uint32_t>{4, 4}));
    EXPECT_EQ(cage.positions.size(), 6u) << "joined again along the seam";
    EXPECT_EQ(cage.uv_sets.at(0).values.size(), 8u) << "where coordinates differ they stay apart";

    g.meshes.insert(g.meshes.size() - 1, R"(, "extras": {"occam": {"scheme": "bilinear", "boundary": "edge-only"}})");
    const Scene by_extras = load(g.write(folder));
    EXPECT_EQ(cages(by_extras).at(0)->scheme, Scheme::Bilinear);
    EXPECT_EQ(cages(by_extras).at(0)->boundary, BoundaryRule::EdgeOnly);
}

TEST(ImportGltf, NodesThatNameOneCageFileShareIt)
{
    const TempFolder folder;
    folder.write("cages/box.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    Gltf g;
    g.nodes = R"({"extras": {"occam": {"cage": "cages/box.obj", "material": 0}}},
                 {"translation": [5, 0, 0], "extras": {"occam": {"cage": "cages/box.obj", "surprise": 1}}},
                 {"extras": {"occam": {"cage": "cages/box.obj", "scheme": "none"}}})";
    g.more = R"(, "materials": [{"name": "gold"}])";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.counts().cages, 2u);
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 3u);
    EXPECT_EQ(list[0], list[1]);
    EXPECT_EQ(list[2]->scheme, Scheme::Triangles);
    EXPECT_TRUE(warns(scene, "unknown key 'surprise'"));
    bool is_gold = false;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        is_gold |= !node.materials.empty() && scene.material(node.materials[0]).name == "gold";
    });
    EXPECT_TRUE(is_gold);
}

TEST(ImportGltf, ExtrasOfTheWrongTypeAreRefused)
{
    const TempFolder folder;
    folder.write("box.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const auto with = [&](const std::string& occam) {
        Gltf g;
        g.nodes = R"({"extras": {"occam": )" + occam + "}}";
        return error_of(g.write(folder));
    };
    EXPECT_EQ(with(R"({"cage": "box.obj"})"), "");
    EXPECT_NE(with(R"({"cage": 7})").find("cage must be a string (nodes[0].extras.occam)"), std::string::npos);
    EXPECT_NE(with(R"({"cage": "../box.obj"})").find("not in the scene's folder"), std::string::npos);
    EXPECT_NE(with(R"({"cage": "box.obj", "scheme": "loop"})").find("catmull-clark, bilinear, none"), std::string::npos);
    EXPECT_NE(with(R"({"cage": "box.obj", "material": 3})").find("no material 3"), std::string::npos);
    EXPECT_NE(with(R"({"area_light": {"size": [1]}})").find("array of 2 numbers"), std::string::npos);
    EXPECT_NE(with(R"({"area_light": {"radiance": [1e300, 0, 0]}})").find("radiance must hold numbers between"),
              std::string::npos);
    Gltf g;
    g.more = R"(, "scenes": [{"nodes": [0], "extras": {"occam": {"environment": {"rotation_deg": -1e300}}}}])";
    EXPECT_NE(error_of(g.write(folder)).find("rotation_deg must be a number between"), std::string::npos);
    EXPECT_NE(with("[1]").find("must be an object"), std::string::npos);
    EXPECT_NE(with(R"({"cage": "missing.obj"})").find("missing.obj: no such file"), std::string::npos);
}

TEST(ImportGltf, ReadsAreaLightsAndTheEnvironment)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"extras": {"occam": {"area_light": {"shape": "disc", "size": [2, 3], "radiance": [4, 5, 6]}}}})";
    g.more = R"(, "scenes": [{"nodes": [0], "extras": {"occam": {"environment": {"strength": 2, "rotation_deg": 90}}}}])";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(scene.environment.radiance, Vec3f(2));
    EXPECT_NEAR(scene.environment.rotation, 1.5707963f, 1e-6f);
    const AreaLight* light = nullptr;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
        if (const Light* l = scene.find(node.light)) light = std::get_if<AreaLight>(&l->kind);
    });
    ASSERT_TRUE(light);
    EXPECT_EQ(light->shape, AreaLight::Shape::Disc);
    EXPECT_EQ(light->size, Vec2f(2, 3));
    EXPECT_EQ(light->radiance, Vec3f(4, 5, 6));
}

// `occam info` counts the lights of the scene, so that a person learns whether anything shines.
TEST(ImportGltf, AScenesLightsAreThoseThatItsNodesHave)
{
    const TempFolder folder;
    Gltf g;
    g.more = R"(, "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [
                    {"type": "point"}, {"type": "directional"}]}})";
    const auto with = [](const std::string& light, const std::string& occam) {
        return R"({"extensions": {"KHR_lights_punctual": {"light": )" + light + R"(}}, "extras": {"occam": {)" + occam +
               "}}}";
    };
    EXPECT_EQ(load(g.write(folder)).counts().lights, 0u);
    g.nodes = with("0", R"("light_group": "key")");
    EXPECT_EQ(load(g.write(folder)).counts().lights, 1u);
    g.nodes += ", " + with("0", "") + ", " + with("0", "") + ", " + with("0", R"("light_group": "key")");
    EXPECT_EQ(load(g.write(folder)).counts().lights, 2u) << "one light in two kinds of groups";
    g.nodes += ", " + with("1", R"("area_light": {"shape": "disc"})");
    EXPECT_EQ(load(g.write(folder)).counts().lights, 3u) << "the area light is taken";
}

TEST(ImportGltf, LightGroupsThatHaveNoEffectAreWarnings)
{
    const TempFolder folder;
    const auto warnings_of = [&](const std::string& nodes) {
        Gltf g;
        g.nodes = nodes;
        return load(g.write(folder)).warnings;
    };
    const std::string lamp = R"({"extras": {"occam": {"area_light": {"shape": "disc"}, "light_group": "key"}}})";
    EXPECT_EQ(warnings_of(lamp + R"(, {"extras": {"occam": {"lit_by": ["key"]}}})"), std::vector<std::string>());
    EXPECT_EQ(warnings_of(lamp + R"(, {"extras": {"occam": {"lit_by": ["key", "kye"]}}})"),
              std::vector<std::string>{"no light belongs to the group that lit_by names (kye)"});
    EXPECT_EQ(warnings_of(R"({"extras": {"occam": {"light_group": "key"}}})"),
              std::vector<std::string>{"light_group has no effect on a node without a light (nodes[0])"});
}

// A light without a mesh is no surface that rays could pass.
TEST(ImportGltf, ALightThatIsHiddenFromRaysIsAWarning)
{
    const TempFolder folder;
    const auto warnings_of = [&](const std::string& extras, const std::string& more) {
        Gltf g;
        g.nodes = R"({"extras": {"occam": {)" + extras + "}}" + more + "}";
        g.more = R"(, "extensionsUsed": ["KHR_lights_punctual"],
                    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}})";
        return load(g.write(folder)).warnings;
    };
    const std::vector<std::string> expected{"hidden_from has no effect on the light of a node (nodes[0])"};
    const std::string hidden = R"("hidden_from": ["camera"])",
                      point = R"(, "extensions": {"KHR_lights_punctual": {"light": 0}})";
    EXPECT_EQ(warnings_of(R"("area_light": {"shape": "disc"}, )" + hidden, ""), expected);
    EXPECT_EQ(warnings_of(hidden, point), expected);
    EXPECT_EQ(warnings_of(hidden, ""), std::vector<std::string>());
}

// The reader of JSON leaves out such values.
TEST(ImportGltf, EmptyExtrasAreWarnings)
{
    const TempFolder folder;
    Gltf g;
    g.nodes =
        R"({"extras": {"occam": {"area_light": {}, "hidden_from": []}}}, {"extras": {"occam": {"lit_by": [], "cage": ""}}},
                 {"extras": {"occam": {}}}, {"extras": []})";
    g.more = R"(, "scenes": [{"nodes": [0, 1, 2, 3], "extras": {"occam": {"environment": null}}}])";
    EXPECT_EQ(load(g.write(folder)).warnings,
              (std::vector<std::string>{"'area_light' is empty, and is not read (nodes[0].extras.occam)",
                                        "'cage' is empty, and is not read (nodes[1].extras.occam)",
                                        "'lit_by' is empty, and is not read (nodes[1].extras.occam)",
                                        "'occam' is empty, and is not read (nodes[2].extras)",
                                        "'environment' is empty, and is not read (scenes[0].extras.occam)"}));
    g.nodes = R"({"extras": {"occam": {"area_light": {"shape": "rect", "size": [], "radiance": null}}}},
        {"extras": {"occam": {"area_light": {"radiance": [1, 2, null, 3]}}}})";
    g.more.clear();
    EXPECT_EQ(
        load(g.write(folder)).warnings,
        (std::vector<std::string>{"'radiance' is empty, and is not read (nodes[0].extras.occam.area_light)",
                                  "'size' is empty, and is not read (nodes[0].extras.occam.area_light)",
                                  "'radiance' has an empty element, which is not read (nodes[1].extras.occam.area_light)"}));
}

// A node that overrides the materials of a cage takes them from no other node that shows the file.
TEST(ImportGltf, TheMaterialsOfACageFileAreThereWhateverOtherNodesSay)
{
    const TempFolder folder;
    folder.write("c.mtl", "newmtl red\nKd 1 0 0\n");
    folder.write("c.obj", "mtllib c.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\n");
    const std::string own = R"({"name": "own", "extras": {"occam": {"cage": "c.obj"}}})",
                      gold = R"({"name": "gold", "extras": {"occam": {"cage": "c.obj", "material": 0}}})";
    for (const std::string& nodes : {own + ", " + gold, gold + ", " + own, gold + ", " + own + ", " + own + ", " + gold}) {
        Gltf g;
        g.nodes = nodes;
        g.more = R"(, "materials": [{"name": "gold"}])";
        const Scene scene = load(g.write(folder));
        EXPECT_EQ(scene.counts().cages, 2u) << "one with materials and one without";
        scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
            if (node.cages.empty()) return;
            const Cage& cage = scene.cage(node.cages.at(0)).cage;
            const std::vector<MaterialId>& materials = node.materials.empty() ? cage.materials : node.materials;
            ASSERT_FALSE(materials.empty()) << node.name;
            EXPECT_EQ(scene.material(materials[0]).name, node.name == "own" ? "red" : "gold") << nodes;
        });
    }
}

// A skin moves a part as a whole or not at all, in whatever order the parts are.
TEST(ImportGltf, APartWithJointsStaysItsOwnCageBesideOneWithout)
{
    const TempFolder folder;
    const std::string rigid = R"({"attributes": {"POSITION": 0}, "indices": 1})",
                      skinned = R"({"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1})";
    for (const std::string& parts : {rigid + ", " + skinned, skinned + ", " + rigid}) {
        Gltf g = square();
        g.put<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
        g.put<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
        g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4"})");
        g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"})");
        g.meshes = R"({"primitives": [)" + parts + "]}";
        const Scene scene = load(g.write(folder), {.subdivide = Subdivide::On});
        int moving_parts = 0;
        for (const Cage* cage : cages(scene)) moving_parts += cage->skin.sets == 1;
        EXPECT_EQ(moving_parts, 1) << parts;
        EXPECT_EQ(cages(scene).size(), 2u) << parts;
    }
}

}  // namespace
}  // namespace occam::test
