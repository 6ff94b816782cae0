// Tests that files with large coordinates, as surveys have them, keep their shape.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "scenegraph/scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

constexpr int kQuads = 10;
constexpr const char* kFormats[] = {"obj", "ply", "off", "stl"};

// A square of 1 x 1 of ten by ten quads, whose corner is at (x, y).
std::string square(const std::string& format, double x, double y)
{
    const auto place = [&](int i, int j) {
        char text[100];
        std::snprintf(text, sizeof(text), "%.3f %.3f 0\n", x + i * 0.1, y + j * 0.1);
        return std::string(text);
    };
    const auto number = [](int i, int j) { return j * (kQuads + 1) + i; };
    std::string vertices, faces;
    for (int j = 0; j <= kQuads; ++j)
        for (int i = 0; i <= kQuads; ++i) vertices += (format == "obj" ? "v " : "") + place(i, j);
    for (int j = 0; j < kQuads; ++j)
        for (int i = 0; i < kQuads; ++i) {
            if (format == "stl") {
                const std::string begin = "facet normal 0 0 1\nouter loop\n", end = "endloop\nendfacet\n", v = "vertex ";
                faces += begin + v + place(i, j) + v + place(i + 1, j) + v + place(i + 1, j + 1) + end;
                faces += begin + v + place(i, j) + v + place(i + 1, j + 1) + v + place(i, j + 1) + end;
                continue;
            }
            faces += format == "obj" ? "f" : "4";
            for (const int v : {number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)})
                faces += " " + std::to_string(format == "obj" ? v + 1 : v);
            faces += "\n";
        }
    if (format == "stl") return "solid s\n" + faces + "endsolid s\n";
    const std::string v = std::to_string(number(kQuads, kQuads) + 1), f = std::to_string(kQuads * kQuads);
    if (format == "off") return "OFF\n" + v + " " + f + " 0\n" + vertices + faces;
    if (format == "obj") return vertices + faces;
    return "ply\nformat ascii 1.0\nelement vertex " + v +
           "\nproperty double x\nproperty double y\nproperty double z\nelement face " + f +
           "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + faces;
}

// Returns the sum of the areas of all triangles, and where the node is.
std::pair<double, Vec3d> area_and_place(const Scene& scene)
{
    const Cage& cage = test::only_cage(scene);
    double area = 0;
    for (std::size_t i = 0; i + 2 < cage.face_vertices.size(); i += 3) {
        const auto corner = [&](std::size_t k) { return Vec3d(cage.positions[cage.face_vertices[i + k]]); };
        area += glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0))) / 2;
    }
    return {area, scene.node(scene.node(scene.root()).children.at(0)).place.translation};
}

TEST(FarPositions, AreKeptRelativeToTheirMiddle)
{
    const test::TempFolder folder;
    for (const std::string format : kFormats) {
        const Scene scene = load(folder.write("far." + format, square(format, 500000.1, 4649776.3)));
        const auto [area, place] = area_and_place(scene);
        EXPECT_NEAR(area, 1, 1e-6) << format;
        EXPECT_NEAR(place.x, 500000.6, 1e-6) << format;
        EXPECT_NEAR(place.y, 4649776.8, 1e-6) << format;
        EXPECT_EQ(test::only_cage(scene).positions.size(), std::size_t((kQuads + 1) * (kQuads + 1))) << format;
        EXPECT_TRUE(scene.warnings.empty()) << format;
    }
}

TEST(FarPositions, OfOtherFilesStayAsTheyAre)
{
    const test::TempFolder folder;
    for (const std::string format : kFormats)
        for (const double x : {0.0, 3.3, 10.1}) {
            const Scene scene = load(folder.write("near." + format, square(format, x, 0)));
            EXPECT_EQ(area_and_place(scene).second, Vec3d(0)) << format << ' ' << x;
            EXPECT_EQ(test::only_cage(scene).positions[0].x, static_cast<float>(x)) << format;
        }
    const Scene whole = load(folder.write("whole.obj", "v 4194304 0 0\nv 4194305 0 0\nv 4194305 1 0\nf 1 2 3\n"));
    EXPECT_EQ(area_and_place(whole).second, Vec3d(0)) << "floats hold these";
}

TEST(FarPositions, OfACageThatAGltfNamesAreAWarning)
{
    const test::TempFolder folder;
    folder.write("far.obj", square("obj", 500000.1, 4649776.3));
    const Scene scene = load(folder.write("a.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"extras": {"occam": {"cage": "far.obj"}}}]})"));
    EXPECT_TRUE(test::warns(scene, "so far from the origin"));
}

}  // namespace
}  // namespace occam
