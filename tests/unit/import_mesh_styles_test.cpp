// Tests that a glTF mesh that nodes show in many styles is read once, and that the copies are charged.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/import/cage_bytes.h"
#include "io/import/gltf_meshes.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::import {
namespace {

// Holds a mesh of one triangle and 1000 morph targets without offsets, which are three bytes each in a file.
struct TargetsWithoutOffsets {
    static constexpr std::size_t kTargets = 1000, kFloats = 9;

    TargetsWithoutOffsets()
    {
        model.buffers.resize(1);
        model.buffers[0].data.resize(kFloats * sizeof(float));
        const float corners[kFloats] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        std::memcpy(model.buffers[0].data.data(), corners, sizeof corners);
        model.bufferViews.resize(1);
        model.bufferViews[0].buffer = 0;
        model.bufferViews[0].byteLength = sizeof corners;
        model.accessors.resize(1);
        tinygltf::Accessor& accessor = model.accessors[0];
        accessor.bufferView = 0, accessor.count = 3;
        accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT, accessor.type = TINYGLTF_TYPE_VEC3;
        model.meshes.resize(1);
        tinygltf::Primitive primitive;
        primitive.attributes["POSITION"] = 0;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        primitive.targets.resize(kTargets);
        model.meshes[0].primitives = {primitive};
    }
    tinygltf::Model model;
};

TEST(MeshStyles, AreChargedForMorphTargetsWithoutOffsets)
{
    const TargetsWithoutOffsets file;
    Report report("a.gltf", false);
    Scene scene;
    const LoadOptions options;
    AccessorReader accessors(file.model, report);
    MaterialImporter materials(file.model, accessors, scene, report);
    MeshImporter meshes(file.model, accessors, materials, scene, report, options);
    CageStyle other;
    other.boundary = BoundaryRule::None;
    const CageId first = meshes.cages(0, {}).at(0);
    constexpr std::size_t kBudget = (std::size_t(512) << 20) + 16 * 36, kList = 1000 * sizeof(MorphTarget);
    ASSERT_EQ(scene.cage(first).cage.morph_targets.size(), 1000u);
    EXPECT_GT(bytes_of(scene.cage(first).cage), kList);

    CopyBudget before = accessors.copies();
    EXPECT_NO_THROW(before.charge(1, kBudget, "the first cage is no copy"));
    EXPECT_NE(meshes.cages(0, other).at(0), first);
    EXPECT_EQ(meshes.cages(0, other).size(), 1u) << "of the same style";
    CopyBudget after = accessors.copies();
    EXPECT_THROW(after.charge(1, kBudget - kList, "a second one is a copy"), Error);
    EXPECT_NO_THROW(accessors.copies().charge(1, kBudget - 2 * kList, "that is charged once"));
}

}  // namespace
}  // namespace occam::import

namespace occam::test {
namespace {

// Returns the square with normals that are too long, in as many nodes as there are styles.
Gltf styled(const std::vector<std::string>& styles)
{
    Gltf g = square(R"(, "extras": {"a": 1})");
    g.put<float>({0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3"})");
    const std::string position = R"("POSITION": 0)";
    g.meshes.insert(g.meshes.find(position) + position.size(), R"(, "NORMAL": 2, "TEXCOORD_0": 3)");
    g.put<float>({0, 0, 1, 0, 1, 1, 0, 1});
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC2"})");
    g.nodes.clear();
    for (const std::string& style : styles)
        g.nodes += (g.nodes.empty() ? "" : ", ") + std::string(R"({"mesh": 0, "extras": {"occam": {)") + style + "}}}";
    g.more = R"(, "images": [{"uri": "a.ppm"}], "textures": [{"source": 0}])";
    return g;
}

// If a primitive were read several times, the warning would count it.
TEST(MeshStyles, ReadAPrimitiveOnce)
{
    const TempFolder folder;
    folder.write("a.ppm", "P6\n1 1\n255\nabc");
    const Scene scene = load(
        styled({R"("boundary": "none")", R"("boundary": "edge-only")", R"("face_varying": "all")"}).write(folder));
    EXPECT_EQ(scene.counts().cages, 3u);
    EXPECT_TRUE(warns(scene, "normals are not of unit length (meshes[0].primitives[0])")) << "there are not several";
}

TEST(MeshStyles, OfTheFirstNodeAreNotThoseOfOthers)
{
    const TempFolder folder;
    folder.write("a.ppm", "P6\n1 1\n255\nabc");
    const Scene scene = load(
        styled({R"("scheme": "bilinear", "boundary": "none", "face_varying": "all",
                                        "displacement": {"texture": 0, "scale": 2})",
                R"("scheme": "catmull-clark")", R"("scheme": "catmull-clark", "displacement": {"texture": 0, "scale": 3})",
                R"("boundary": "edge-only")", R"("face_varying": "none")"})
            .write(folder));
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 5u);
    EXPECT_EQ(list[0]->scheme, Scheme::Bilinear);
    EXPECT_EQ(list[0]->boundary, BoundaryRule::None);
    EXPECT_EQ(list[0]->face_varying, FaceVaryingRule::All);
    ASSERT_TRUE(list[0]->displacement && list[2]->displacement);
    EXPECT_EQ(list[0]->displacement->scale, 2);
    EXPECT_EQ(list[2]->displacement->scale, 3);
    EXPECT_FALSE(list[1]->displacement || list[3]->displacement || list[4]->displacement);
    for (const int i : {1, 2, 3, 4}) {
        const Cage& cage = *list[static_cast<std::size_t>(i)];
        EXPECT_EQ(cage.scheme, i < 3 ? Scheme::CatmullClark : Scheme::Triangles) << i;
        EXPECT_EQ(cage.boundary, i == 3 ? BoundaryRule::EdgeOnly : BoundaryRule::EdgeAndCorner) << i;
        EXPECT_EQ(cage.face_varying, i == 4 ? FaceVaryingRule::None : FaceVaryingRule::CornersPlus1) << i;
        EXPECT_EQ(cage.positions, list[0]->positions) << i;
        EXPECT_EQ(cage.face_sizes.empty(), i >= 3) << i;
        EXPECT_EQ(cage.normals.empty(), i < 3) << i;
    }
}

// Many nodes may show a camera, so its name must not be long where it is told.
TEST(LongNames, OfCamerasAreCutOffInWarnings)
{
    const TempFolder folder;
    Gltf g;
    g.nodes = R"({"camera": 0}, {"camera": 0})";
    g.more = R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 3.12, "znear": 1}, "name": ")" +
             std::string(10'000, 'a') + R"("}])";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(warns(scene, "a camera's angle above 3.1 radians is made smaller (cameras[0] 'aaaa"));
    for (const std::string& line : scene.warnings) EXPECT_LT(line.size(), 300u);
}

}  // namespace
}  // namespace occam::test
