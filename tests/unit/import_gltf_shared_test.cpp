// Tests of primitives that each use a part of the same accessors.
#include <gtest/gtest.h>

#include <bit>

#include "tests/support/gltf_scene.h"
#include "tests/support/import_errors.h"

namespace occam::test {
namespace {

std::string view_of(std::size_t begin, std::size_t bytes)
{
    return R"({"buffer": 0, "byteOffset": )" + std::to_string(begin) + R"(, "byteLength": )" + std::to_string(bytes) + "}";
}
void append_bytes_of(std::string& to, std::uint32_t x)
{
    for (int i = 0; i < 4; ++i) to += static_cast<char>(x >> 8 * i & 0xff);
}

// Returns `parts` primitives of `size` vertices each, all of one accessor, as triangles of three neighbours.
Gltf slices(std::uint32_t parts, std::uint32_t size)
{
    Gltf g;
    const std::uint32_t vertices = parts * size;
    for (std::uint32_t v = 0; v < vertices; ++v)
        for (const float x : {float(v % size), float(v % 2), float(v / size)})
            append_bytes_of(g.bin, std::bit_cast<std::uint32_t>(x));
    const std::size_t places = g.bin.size();
    for (std::uint32_t p = 0; p < parts; ++p)
        for (std::uint32_t v = 0; v + 2 < size; ++v)
            for (std::uint32_t c = 0; c < 3; ++c) append_bytes_of(g.bin, p * size + v + c);
    g.buffer_views = view_of(0, places) + ", " + view_of(places, g.bin.size() - places);
    g.accessor(R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" + std::to_string(vertices) +
               R"(, "min": [0, 0, 0], "max": [)" + std::to_string(size - 1) + ", 1, " + std::to_string(parts - 1) + "]}");
    std::string primitives;
    for (std::uint32_t p = 0; p < parts; ++p) {
        const std::size_t corners = (size - 2) * 3;
        g.accessor(R"({"bufferView": 1, "componentType": 5125, "type": "SCALAR", "byteOffset": )" +
                   std::to_string(p * corners * 4) + R"(, "count": )" + std::to_string(corners) + "}");
        primitives += (p ? ", " : "") + std::string(R"({"attributes": {"POSITION": 0}, "indices": )") +
                      std::to_string(p + 1) + "}";
    }
    g.meshes = R"({"primitives": [)" + primitives + "]}";
    g.nodes = R"({"mesh": 0})";
    return g;
}

// All vertices of all primitives would take a gigabyte, but each of them is used once.
TEST(GltfSharedVertices, MayBeUsedByManyPrimitives)
{
    const TempFolder folder;
    const Scene scene = load(slices(1000, 100).write(folder));
    EXPECT_TRUE(scene.warnings.empty());
    const auto list = cages(scene);
    ASSERT_EQ(list.size(), 1000u);
    for (std::size_t p = 0; p < list.size(); ++p) {
        ASSERT_EQ(list[p]->positions.size(), 100u);
        EXPECT_EQ(list[p]->positions.at(99), Vec3f(99, 1, p));
        EXPECT_EQ(list[p]->face_vertices.at(5), 3u);
    }
}

// The time and memory of a primitive do not depend on how many vertices there are. If they did, there would be 10^13 steps.
TEST(GltfSharedVertices, TakeTimeOnlyWhereTheyAreUsed)
{
    const TempFolder folder;
    Gltf g = slices(1, 5);
    g.accessors.clear();
    g.accessor(R"({"componentType": 5126, "type": "VEC3", "count": 4000000000, "min": [0, 0, 0], "max": [0, 0, 0]})");
    g.accessor(R"({"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3})");
    g.meshes.clear();
    for (int p = 0; p < 2500; ++p)
        g.meshes += (p ? ", " : R"({"primitives": [)") + std::string(R"({"attributes": {"POSITION": 0}, "indices": 1})");
    g.meshes += "]}";
    EXPECT_NE(error_of(g.write(folder)).find("far more than the buffers hold (accessors[0])"), std::string::npos)
        << "a check of all values comes last";
}

// The parts of a sparse accessor that are not used must not move those that are.
TEST(GltfSharedVertices, OfSparseAccessorsAreThoseThatTheirNumbersName)
{
    const TempFolder folder;
    Gltf g;
    g.put<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0, 6, 0, 0, 7, 0, 0});
    g.put<std::uint8_t>({1, 4, 5, 7});
    g.put<float>({1, 1, 1, 4, 4, 4, 5, 5, 5, 7, 7, 7});
    g.put<std::uint8_t>({6, 5, 2, 6, 9, 7});
    g.accessor(R"({"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [7, 7, 7],
        "sparse": {"count": 4, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 2}}})");
    g.accessor(R"({"bufferView": 3, "componentType": 5121, "count": 6, "type": "SCALAR"})");
    g.meshes = R"({"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1}]})";
    g.nodes = R"({"mesh": 0})";
    const Scene scene = load(g.write(folder));
    const Cage& cage = *cages(scene).at(0);
    ASSERT_GE(cage.positions.size(), 3u);
    EXPECT_EQ(cage.positions[0], Vec3f(2, 0, 0));
    EXPECT_EQ(cage.positions[1], Vec3f(5, 5, 5));
    EXPECT_EQ(cage.positions[2], Vec3f(6, 0, 0));
}

}  // namespace
}  // namespace occam::test
