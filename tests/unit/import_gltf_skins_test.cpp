// Tests of the skins of glTF files.
#include <gtest/gtest.h>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

// Returns a square that hangs on the joints of a skin: nodes[0] wears it, and the joints begin with nodes[1].
Gltf skinned_square()
{
    Gltf g = square();
    g.put<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    g.put<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3}, "indices": 1}]})";
    g.nodes = R"({"name": "wearer", "mesh": 0, "skin": 0}, {"name": "joint", "translation": [5, 0, 0]})";
    g.more = R"(, "skins": [{"joints": [1]}])";
    return g;
}

Mat4d mesh_of_first_joint(const Scene& scene)
{
    return scene.skin(scene.node(scene.find_node("wearer")).skin).joint_from_mesh.at(0);
}

TEST(GltfSkins, ASkinWithAJointOutsideTheSceneIsLeftOut)
{
    const TempFolder folder;
    Gltf g = skinned_square();
    g.more += R"(, "scene": 0, "scenes": [{"nodes": [0]}])";
    const Scene scene = load(g.write(folder));
    EXPECT_TRUE(warns(scene, "skin left out: a joint is not in the scene (skins[0])"));
    EXPECT_FALSE(scene.node(scene.find_node("wearer")).skin);
    EXPECT_EQ(only_cage(scene).face_count(), 2u) << "the mesh is still there";
}

// Matrices that programs invert have a last row that is off by the rounding of floats, or have a common factor.
TEST(GltfSkins, TheLastRowOfAnInverseBindMatrixIsMended)
{
    const TempFolder folder;
    const auto with = [&](float factor, float error) {
        Gltf g = skinned_square();
        const float f = factor;
        g.put<float>({f, 0, 0, error, 0, f, 0, 0, 0, 0, f, 0, -5 * f, 0, 0, f + error});
        g.accessor(R"({"bufferView": 4, "componentType": 5126, "count": 1, "type": "MAT4"})");
        g.more = R"(, "skins": [{"joints": [1], "inverseBindMatrices": 4}])";
        return load(g.write(folder));
    };
    Mat4d expected(1);
    expected[3][0] = -5;
    EXPECT_TRUE(with(1, 0).warnings.empty());
    EXPECT_EQ(mesh_of_first_joint(with(1, 0)), expected);
    EXPECT_TRUE(with(1, 1e-7f).warnings.empty()) << "rounding is no fault of the file";
    for (const float error : {1e-7f, -1e-7f, 1e-3f}) {
        const Mat4d found = mesh_of_first_joint(with(1, error));
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r) EXPECT_NEAR(found[c][r], expected[c][r], 6e-3) << error << c << r;
        EXPECT_EQ(Vec4d(found[0][3], found[1][3], found[2][3], found[3][3]), Vec4d(0, 0, 0, 1)) << error;
    }
    EXPECT_TRUE(warns(with(1, 1e-3f), "the last row of an inverse bind matrix is not 0, 0, 0, 1: it is taken as that"));
    EXPECT_EQ(mesh_of_first_joint(with(2, 0)), expected) << "all elements are divided by the last";
    EXPECT_TRUE(warns(with(2, 0), "the last row of an inverse bind matrix is not 0, 0, 0, 1"));
    EXPECT_EQ(mesh_of_first_joint(with(0, 0)), Mat4d(1)) << "this one cannot be mended";
    EXPECT_TRUE(warns(with(0, 0), "an inverse bind matrix is replaced by the identity"));
}

// nodes[2] and those after it are a chain. At its end are the joints, or else what wears the skins.
Gltf skins_below_a_chain(int length, int joints, int skins, int wearers, int worn = 0)
{
    const auto list = [](int first, int count) {
        std::string text = "[";
        for (int i = 0; i < count; ++i) text += (i > 0 ? "," : "") + std::to_string(first + i);
        return text + "]";
    };
    Gltf g = skinned_square();
    const int end = length + 1, first = end + 1;
    for (int i = 2; i < end; ++i) g.nodes += R"(,{"children":)" + list(i + 1, 1) + "}";
    g.nodes += R"(,{"children":)" + list(first, joints + wearers) + "}";
    for (int i = 0; i < joints; ++i) g.nodes += ",{}";
    for (int i = 0; i < wearers; ++i) g.nodes += R"(,{"mesh":0,"skin":)" + std::to_string(worn) + "}";
    g.more = R"(, "skins": [{"joints": [1]})";
    const std::string far_joints = list(first, joints);
    for (int i = 0; i < skins; ++i) g.more += R"(,{"joints":[1,)" + far_joints.substr(1) + "}";
    g.more += "]";
    return g;
}

TEST(GltfSkins, BelowTooManyNodesAreRefused)
{
    const TempFolder folder;
    EXPECT_EQ(error_of(skins_below_a_chain(1000, 100, 20, 500).write(folder)), "");
    const std::string why =
        "there are too many nodes above the joints of skins and above what wears them, or too many joints in what is worn (";
    EXPECT_NE(error_of(skins_below_a_chain(4000, 100, 50, 0).write(folder)).find(why + "skins[42])"), std::string::npos);
    EXPECT_NE(error_of(skins_below_a_chain(4000, 100, 41, 100).write(folder)).find(why + "nodes["), std::string::npos);
    EXPECT_NE(error_of(skins_below_a_chain(1, 5000, 1, 4000, 1).write(folder)).find(why + "nodes["), std::string::npos)
        << "each wearer has as many joints as its skin";
}

TEST(GltfSkins, InstancesThatCannotBeDeformedAreNamed)
{
    const TempFolder folder;
    Gltf g = skinned_square();
    g.nodes.insert(g.nodes.find("}"), R"(, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}})");
    g.more += R"(, "extensionsUsed": ["EXT_mesh_gpu_instancing"])";
    EXPECT_TRUE(warns(load(g.write(folder)), "instances are not deformed by the skin of their node (nodes[0])"));
}

}  // namespace
}  // namespace occam::test
