// Tests of subdivision cages that come from several primitives of one glTF mesh.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

/// What a primitive has beside positions and indices.
struct Part {
    std::string attributes, targets;
};

// Returns two squares that share an edge: vertices 0 to 3, and 4 to 7. They are of one primitive, or of two if there are two
// parts. Accessors 4 to 6 are joints, weights and weights of 0; those from 7 on are offsets: of the upper square, and of 0.
Gltf squares(const std::vector<Part>& parts)
{
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 0, 2, 0});
    g.put<std::uint16_t>({0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
    g.put<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    g.put<float>(
        {0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    g.put<float>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 3, 1, 0, 3});
    const std::string positions = R"({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",)";
    g.accessor(positions + R"("min": [0, 0, 0], "max": [1, 2, 0]})");
    for (const char* range :
         {R"("byteOffset": 0, "count": 12)", R"("byteOffset": 0, "count": 6)", R"("byteOffset": 12, "count": 6)"})
        g.accessor(R"({"bufferView": 1, "componentType": 5123, "type": "SCALAR", )" + std::string(range) + "}");
    g.accessor(R"({"bufferView": 2, "componentType": 5121, "count": 8, "type": "VEC4"})");
    g.accessor(R"({"bufferView": 3, "componentType": 5126, "count": 8, "type": "VEC4"})");
    g.accessor(R"({"componentType": 5126, "count": 8, "type": "VEC4"})");
    g.accessor(
        R"({"bufferView": 4, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 3]})");
    g.accessor(R"({"componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]})");
    for (std::size_t p = 0; p < parts.size(); ++p)
        g.meshes += (p > 0 ? ", " : "") + std::string(R"({"attributes": {"POSITION": 0)") + parts[p].attributes +
                    R"(}, "indices": )" + std::to_string(parts.size() == 1 ? 1 : 2 + p) + R"(, "targets": [)" +
                    parts[p].targets + R"(], "material": )" + std::to_string(p) + "}";
    g.meshes = R"({"weights": [0.5, 0.25], "primitives": [)" + g.meshes + "]}";
    g.nodes = R"({"mesh": 0, "skin": 0}, {}, {})";
    g.more = R"(, "skins": [{"joints": [1, 2]}], "materials": [{"name": "a"}, {"name": "b"}])";
    return g;
}

Scene subdivided(const std::vector<Part>& parts)
{
    const TempFolder folder;
    return load(squares(parts).write(folder), {.subdivide = Subdivide::On});
}

// A border of materials is no border of the surface, whatever moves it.
TEST(GltfJoinedCages, PrimitivesAreOneSurfaceInEveryPose)
{
    const std::string moved = R"({"POSITION": 7})", still = R"({"POSITION": 8})";
    const std::string joints = R"(, "JOINTS_0": 4, "WEIGHTS_0": 5)", more_joints = R"(, "JOINTS_1": 4, "WEIGHTS_1": 6)";
    struct Case {
        const char* name;
        Part whole, lower, upper;
    };
    const Case cases[] = {
        {"still", {}, {}, {}},
        {"morph", {"", moved}, {"", moved}, {"", moved}},
        {"two targets", {"", moved + "," + moved}, {"", still + "," + moved}, {"", moved + "," + moved}},
        {"a target of the second alone", {"", moved}, {}, {"", moved}},
        {"a second target of the first alone", {"", moved + "," + still}, {"", moved + "," + still}, {"", moved}},
        {"skin", {joints, ""}, {joints, ""}, {joints, ""}},
        {"more joints of the first", {joints + more_joints, ""}, {joints + more_joints, ""}, {joints, ""}},
        {"more joints of the second", {joints + more_joints, ""}, {joints, ""}, {joints + more_joints, ""}},
        {"both", {joints, moved}, {joints, ""}, {joints, moved}},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.name);
        const Scene one = subdivided({c.whole}), two = subdivided({c.lower, c.upper});
        ASSERT_EQ(cages(one).size(), 1u);
        ASSERT_EQ(cages(two).size(), 1u);
        const Cage &a = *cages(one)[0], &b = *cages(two)[0];
        EXPECT_EQ(a.positions.size(), 6u) << "the squares share an edge";
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.face_sizes, b.face_sizes);
        EXPECT_EQ(a.face_vertices, b.face_vertices);
        EXPECT_EQ(a.morph_weights, b.morph_weights);
        ASSERT_EQ(a.morph_targets.size(), b.morph_targets.size());
        for (std::size_t t = 0; t < a.morph_targets.size(); ++t)
            EXPECT_EQ(a.morph_targets[t].positions, b.morph_targets[t].positions) << t;
        EXPECT_EQ(a.skin.sets, b.skin.sets);
        EXPECT_EQ(a.skin.weights, b.skin.weights);
        EXPECT_EQ(b.materials.size(), 2u);
        EXPECT_EQ(b.face_slots.front(), 0u);
        EXPECT_EQ(b.face_slots.back(), 1u);
    }
}

TEST(GltfJoinedCages, PrimitivesWithJointsAreApartFromThoseWithout)
{
    const Scene scene = subdivided({{}, {R"(, "JOINTS_0": 4, "WEIGHTS_0": 5)", ""}});
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0]->skin.sets, 0);
    EXPECT_EQ(list[1]->skin.sets, 1);
    EXPECT_TRUE(warns(scene, "primitives with joints are subdivided apart from those without (meshes[0])"));
}

TEST(GltfJoinedCages, ASmallFileCannotAskForManyOffsetsOfZero)
{
    const TempFolder folder;
    Gltf g = squares({{}, {}});
    g.put<float>({});
    g.bin += std::string(36 * 6000, '\0');
    g.buffer_views.replace(g.buffer_views.rfind(R"("byteLength": 0)"), 15, R"("byteLength": 216000)");
    g.accessor(
        R"({"bufferView": 5, "componentType": 5126, "count": 18000, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]})");
    std::string targets = R"({"POSITION": 7})";
    for (int t = 1; t < 8000; ++t) targets += R"(,{"POSITION": 7})";
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "targets": [)" + targets +
               R"(]}, {"attributes": {"POSITION": 9}}]})";
    const std::string error = error_of(g.write(folder), {.subdivide = Subdivide::On});
    EXPECT_NE(error.find("too many copies of what it holds once (meshes[0])"), std::string::npos) << error;
}

}  // namespace
}  // namespace occam::test
