// Tests of what morph targets, skins and their animation make of vertices and instances in glTF files.
#include <gtest/gtest.h>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

// Returns two squares, a lower and an upper one, that meet in two places at rest: vertices 2 and 5, and 3 and 4.
Gltf lips(const std::string& primitive_more, const std::string& attributes = "")
{
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0});
    g.put<std::uint16_t>({0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
    g.accessor(
        R"({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0)" + attributes + R"(}, "indices": 1)" + primitive_more +
               "}]}";
    g.nodes = R"({"mesh": 0})";
    return g;
}

std::size_t vertices_of_cage(const Gltf& g)
{
    const TempFolder folder;
    const Scene scene = load(g.write(folder), {.subdivide = Subdivide::On});
    return cages(scene).at(0)->positions.size();
}

TEST(GltfMorphs, LipsThatAreClosedAtRestCanOpen)
{
    const auto with_target = [](std::initializer_list<float> moves) {
        Gltf g = lips(R"(, "targets": [{"POSITION": 2}])");
        g.put<float>(moves);
        g.accessor(
            R"({"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [0, 1, 0]})");
        return g;
    };
    EXPECT_EQ(vertices_of_cage(lips("")), 6u);
    EXPECT_EQ(vertices_of_cage(with_target({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0})), 6u);
    EXPECT_EQ(vertices_of_cage(with_target({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0})), 8u);
    EXPECT_EQ(vertices_of_cage(with_target({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0})), 7u)
        << "one corner of the mouth stays closed";
}

TEST(GltfMorphs, LipsOfDifferentJointsCanOpen)
{
    using Joints = std::initializer_list<std::uint16_t>;
    using Weights = std::initializer_list<float>;
    const auto with_skin = [](Joints lower, Weights lower_weights, Joints upper, Weights upper_weights) {
        Gltf g = lips("", R"(, "JOINTS_0": 2, "WEIGHTS_0": 3)");
        std::string joints, weights;
        const auto append = [](std::string& to, const auto& values) {
            for (const auto value : values) to.append(reinterpret_cast<const char*>(&value), sizeof value);
        };
        for (int v = 0; v < 8; ++v) {
            append(joints, v < 4 ? lower : upper);
            append(weights, v < 4 ? lower_weights : upper_weights);
        }
        for (const std::string& data : {joints, weights}) {
            g.put<std::uint32_t>({});
            g.bin += data;
            g.buffer_views.replace(g.buffer_views.rfind(R"("byteLength": 0)"), 15,
                                   R"("byteLength": )" + std::to_string(data.size()));
        }
        g.accessor(R"({"bufferView": 2, "componentType": 5123, "count": 8, "type": "VEC4"})");
        g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 8, "type": "VEC4"})");
        g.nodes = R"({"mesh": 0, "skin": 0}, {}, {})";
        g.more = R"(, "skins": [{"joints": [1, 2]}])";
        return g;
    };
    EXPECT_EQ(vertices_of_cage(with_skin({0, 1, 0, 0}, {0.5f, 0.5f, 0, 0}, {0, 1, 0, 0}, {0.5f, 0.5f, 0, 0})), 6u);
    EXPECT_EQ(vertices_of_cage(with_skin({0, 1, 0, 0}, {0.25f, 0.75f, 0, 0}, {1, 0, 1, 1}, {0.75f, 0.25f, 0, 0})), 6u)
        << "the order of joints and those without weight do not matter";
    EXPECT_EQ(vertices_of_cage(with_skin({0, 1, 0, 0}, {0.5f, 0.5f, 0, 0}, {0, 1, 0, 0}, {0.25f, 0.75f, 0, 0})), 8u);
    EXPECT_EQ(vertices_of_cage(with_skin({0, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0})), 8u);
}

TEST(GltfMorphs, AnimatedWeightsMoveAllInstances)
{
    Gltf g = square(R"(, "targets": [{"POSITION": 0}])");
    g.put<float>({0, 0, 0, 5, 0, 0, 0, 7, 0});
    g.put<float>({0, 1});
    g.put<float>({0.25f, 0.75f});
    g.accessor(R"({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]})");
    g.accessor(R"({"bufferView": 4, "componentType": 5126, "count": 2, "type": "SCALAR"})");
    g.nodes = R"({"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
        {"TRANSLATION": 2}}}})";
    g.more = R"(, "extensionsUsed": ["EXT_mesh_gpu_instancing"], "animations": [{"name": "smile", "channels": [
        {"sampler": 0, "target": {"node": 0, "path": "weights"}},
        {"sampler": 1, "target": {"node": 0, "path": "translation"}}], "samplers": [
        {"input": 3, "output": 4}, {"input": 3, "output": 5}]}])";
    g.put<float>({0, 0, 1, 0, 0, 3});
    g.accessor(R"({"bufferView": 5, "componentType": 5126, "count": 2, "type": "VEC3"})");
    const TempFolder folder;
    Scene scene = load(g.write(folder), {.strict = true});
    scene.pose(scene.clips().at(0), 1);
    int shown = 0;
    scene.for_each_placement([&](NodeId, const Node& node, const Mat4d& world_from_node) {
        if (node.cages.empty()) return;
        ++shown;
        EXPECT_EQ(node.morph_weights, std::vector<float>{0.75f});
        EXPECT_EQ(world_from_node[3].z, 3);
    });
    EXPECT_EQ(shown, 3);
}

}  // namespace
}  // namespace occam::test
