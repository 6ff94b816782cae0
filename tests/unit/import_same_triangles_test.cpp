// Tests that triangles in one place are kept once, in files that hold thousands of them, and that no others are dropped.
#include <gtest/gtest.h>

#include <random>

#include "io/import/same_triangles.h"
#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam {
namespace {

using test::only_cage;
using test::TempFolder;
using test::warns;

constexpr const char* kCorners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
constexpr const char* kWarning = "another one lies in the same place";

std::string repeated(const std::string& line, int times)
{
    std::string text;
    for (int i = 0; i < times; ++i) text += line;
    return text;
}

TEST(SameTriangles, OfAFaceThatGoesAroundThousandsOfTimesAreKeptOnce)
{
    const TempFolder folder;
    const Scene scene = load(folder.write("face.obj", kCorners + ("f" + repeated(" 1 2 3", 10'000) + "\n")));
    EXPECT_LE(only_cage(scene).face_count(), 6u);
    EXPECT_TRUE(warns(scene, kWarning));
}

TEST(SameTriangles, AreKeptOnceForEachDirectionWhateverTheirMaterialsAndVertices)
{
    const TempFolder folder;
    std::string text;
    for (int i = 0; i < 2000; ++i) {
        text.append(kCorners).append("usemtl m").append(std::to_string(i)).append("\n");
        text += "f -4 -3 -2\nf -3 -2 -4\nf -3 -4 -2\nf -4 -3 -1\n";
    }
    const Scene scene = load(folder.write("many.obj", text));
    EXPECT_EQ(only_cage(scene).face_count(), 3u);
}

TEST(SameTriangles, OfGltfAreKeptOnce)
{
    const TempFolder folder;
    test::Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const std::size_t first = g.bin.size();
    for (int i = 0; i < 5000; ++i)
        for (const char v : {0, 1, 2}) g.bin += v;
    g.buffer_views += R"(, {"buffer": 0, "byteOffset": )" + std::to_string(first) + R"(, "byteLength": 15000})";
    g.accessor(
        R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5121, "count": 15000, "type": "SCALAR"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})";
    g.nodes = R"({"mesh": 0})";
    const Scene scene = load(g.write(folder));
    EXPECT_EQ(only_cage(scene).face_count(), 1u);
    EXPECT_TRUE(warns(scene, kWarning));
}

TEST(SameTriangles, OfAnOrdinaryMeshAreNotLookedFor)
{
    // A grid of 60 by 60 quads, with one triangle twice.
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (int i = 0; i < 61 * 61; ++i) cage.positions.push_back({float(i % 61), float(i / 61), 0});
    for (std::uint32_t y = 0; y < 60; ++y)
        for (std::uint32_t x = 0; x < 60; ++x) {
            const std::uint32_t v = y * 61 + x;
            cage.face_vertices.insert(cage.face_vertices.end(), {v, v + 1, v + 62, v, v + 62, v + 61});
        }
    cage.face_vertices.insert(cage.face_vertices.end(), {0, 1, 62});
    import::Report report("grid.obj", true);  // a warning would be an error
    import::drop_same_triangles(cage, report);
    EXPECT_EQ(cage.face_count(), 7201u);
}

TEST(SameTriangles, ThatOverlapInHundredsOfThousandsAreRefused)
{
    Cage cage;
    cage.name = "soup";
    cage.scheme = Scheme::Triangles;
    std::mt19937 random(3);
    for (int i = 0; i < 1000; ++i)
        cage.positions.push_back({float(random() % 997), float(random() % 997), float(random() % 997)});
    const import::Report report("soup.ply", false);
    const auto soup_of = [&](std::size_t triangles) {
        cage.face_vertices.resize(3 * triangles);
        for (std::uint32_t& v : cage.face_vertices) v = static_cast<std::uint32_t>(random() % 1000);
    };
    soup_of(300'000);  // a random triangle's box takes a quarter of the size of the whole
    EXPECT_NO_THROW(import::check_boxes(cage, report));
    soup_of(800'000);
    EXPECT_THROW(import::check_boxes(cage, report), Error);
    // Hundreds of thousands of small triangles are an ordinary mesh.
    for (std::size_t c = 0; c < cage.face_vertices.size(); c += 3)
        for (std::size_t k = 1; k < 3; ++k) cage.face_vertices[c + k] = cage.face_vertices[c];
    EXPECT_NO_THROW(import::check_boxes(cage, report));
}

TEST(SameTriangles, OfAMeshThatIsDeformedAreThoseThatMoveAlike)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    for (int i = 0; i < 2; ++i) cage.positions.insert(cage.positions.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    for (int i = 0; i < 3000; ++i) cage.face_vertices.insert(cage.face_vertices.end(), {0, 1, 2, 3, 4, 5});
    cage.morph_targets.resize(1);
    cage.morph_targets[0].positions.assign(6, Vec3f(0));
    cage.morph_targets[0].positions[5] = Vec3f(1);
    import::Report report("morph.gltf", false);
    Cage alike = cage;
    alike.morph_targets[0].positions[2] = Vec3f(1);
    import::drop_same_triangles(cage, report);
    EXPECT_EQ(cage.face_count(), 2u);
    import::drop_same_triangles(alike, report);
    EXPECT_EQ(alike.face_count(), 1u);
}

}  // namespace
}  // namespace occam
