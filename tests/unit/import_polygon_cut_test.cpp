// Tests that the triangles of a polygon cover it and nothing else, also where it touches itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "io/import/polygons.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam::import {
namespace {

// Sums of the areas of the triangles: as they are, and with those that are seen from behind below 0. The two are equal if
// none is turned over, which one that leaves the polygon makes necessary.
struct Areas {
    double all = 0, turned = 0;
    CutPolygon result = CutPolygon::Whole;
};

Areas areas_of(std::span<const Vec3f> polygon)
{
    std::vector<std::uint32_t> cut;
    Areas areas;
    EarBudget budget = EarBudget::of_file(polygon.size());
    areas.result = cut_polygon(polygon, budget, cut);
    EXPECT_EQ(cut.size(), 3 * (polygon.size() - 2));
    for (std::size_t i = 0; i + 2 < cut.size(); i += 3) {
        const Vec3d a(polygon[cut[i]]), b = Vec3d(polygon[cut[i + 1]]) - a, c = Vec3d(polygon[cut[i + 2]]) - a;
        const double area = (b.x * c.y - b.y * c.x) / 2;
        areas.all += std::abs(area), areas.turned += area;
    }
    return areas;
}

void expect_whole(std::span<const Vec3f> polygon, const std::string& what)
{
    const Areas areas = areas_of(polygon);
    EXPECT_EQ(areas.result, CutPolygon::Whole) << what;
    EXPECT_GT(areas.turned, 0) << what;
    EXPECT_NEAR(areas.all, areas.turned, 1e-9 * areas.all) << what;
}

// Returns a regular polygon; with fewer than 0 corners it runs the other way round.
std::vector<Vec3f> ring(int corners, double radius, double turn, Vec3f middle = Vec3f(0))
{
    std::vector<Vec3f> ring;
    for (int i = 0; i < std::abs(corners); ++i) {
        const double angle = turn + i * 2 * 3.14159265358979 / corners;
        ring.push_back(middle +
                       Vec3f(static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)), 0));
    }
    return ring;
}

// Goes from the corner of `outer` that is nearest to a corner of `hole` around the hole and back. No other hole may be in
// the way.
void add_hole(std::vector<Vec3f>& outer, const std::vector<Vec3f>& hole)
{
    std::size_t from = 0, to = 0;
    for (std::size_t i = 0; i < outer.size(); ++i)
        for (std::size_t j = 0; j < hole.size(); ++j)
            if (glm::distance(outer[i], hole[j]) < glm::distance(outer[from], hole[to])) from = i, to = j;
    std::vector<Vec3f> way;
    for (std::size_t j = 0; j <= hole.size(); ++j) way.push_back(hole[(to + j) % hole.size()]);
    way.push_back(outer[from]);
    outer.insert(outer.begin() + static_cast<std::ptrdiff_t>(from) + 1, way.begin(), way.end());
}

TEST(PolygonCut, FacesWithHolesAreCutBesideThem)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> turn(0, 6.28);
    for (int k = 0; k < 300; ++k) {
        std::vector<Vec3f> polygon = ring(3 + int(random() % 10), 2, turn(random));
        add_hole(polygon, ring(-3 - int(random() % 10), 0.4, turn(random)));
        expect_whole(polygon, "one hole, " + std::to_string(k));
    }
    for (int holes = 2; holes < 30; ++holes) {
        constexpr float kApart = 6;
        std::vector<Vec3f> polygon = {{-3, -2, 0}, {kApart * float(holes), -2, 0}};
        for (int h = holes; h-- > 0;) polygon.emplace_back(kApart * float(h), 2, 0);
        polygon.emplace_back(-3, 2, 0);
        for (int h = 0; h < holes; ++h)
            add_hole(polygon, ring(-3 - int(random() % 9), 1, turn(random), Vec3f(kApart * float(h), 0, 0)));
        expect_whole(polygon, std::to_string(holes) + " holes");
    }
}

TEST(PolygonCut, AHoleMayBeReachedFromAnotherHole)
{
    const std::vector<Vec3f> polygon = {{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {0, 9, 0}, {0, 0, 0}, {1, 1, 0},
                                        {1, 3, 0}, {3, 3, 0}, {5, 5, 0}, {5, 7, 0}, {7, 7, 0}, {7, 5, 0},
                                        {5, 5, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
    expect_whole(polygon, "a chain of holes");
    EXPECT_NEAR(areas_of(polygon).all, 81 - 8, 1e-9);
}

TEST(PolygonCut, LoopsThatShareACornerStayApart)
{
    std::mt19937 random(2);
    for (int k = 0; k < 300; ++k) {
        const int left = 3 + int(random() % 10), right = 3 + int(random() % 10);
        std::vector<Vec3f> polygon = ring(right, 1, 3.14159265358979, Vec3f(1, 0, 0));
        const std::vector<Vec3f> other = ring(left, 1, 0, Vec3f(-1, 0, 0));
        polygon.insert(polygon.end(), other.begin(), other.end());
        polygon[0] = polygon[std::size_t(right)] = Vec3f(0);
        expect_whole(polygon, std::to_string(k));
    }
}

TEST(PolygonCut, RepeatedCornersAndSlitsChangeNothing)
{
    const std::vector<Vec3f> l_shape = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    for (std::size_t twice = 0; twice < l_shape.size(); ++twice) {
        std::vector<Vec3f> polygon = l_shape;
        polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(twice), 3, l_shape[twice]);
        expect_whole(polygon, std::to_string(twice));
        EXPECT_NEAR(areas_of(polygon).all, 5, 1e-9);
    }
    const std::vector<Vec3f> slit = {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 4, 0}, {2, 2, 0}, {2, 4, 0}, {0, 4, 0}};
    expect_whole(slit, "slit");
    EXPECT_NEAR(areas_of(slit).all, 16, 1e-9);
    const std::vector<Vec3f> in_line = {{0, 0, 0}, {6, 0, 0}, {6, 6, 0}, {0, 6, 0}, {0, 0, 0},
                                        {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {1, 1, 0}};
    expect_whole(in_line, "an edge of the hole goes on from the way to it");
    EXPECT_NEAR(areas_of(in_line).all, 35.5, 1e-9);
}

// The edge between the two corners has no direction, so it does not show that the polygon turns back.
TEST(PolygonCut, ASlitMayEndAtARepeatedCorner)
{
    const std::vector<Vec3f> square = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0},
                                       {1, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    for (std::size_t first = 0; first < square.size(); ++first) {
        std::vector<Vec3f> polygon(square);
        std::rotate(polygon.begin(), polygon.begin() + static_cast<std::ptrdiff_t>(first), polygon.end());
        expect_whole(polygon, "from corner " + std::to_string(first));
        EXPECT_NEAR(areas_of(polygon).all, 4, 1e-9) << first;
    }
}

TEST(PolygonCut, AHoleOfAFileStaysOpen)
{
    const test::TempFolder folder;
    const std::string corners = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\n";
    const Scene scene = load(folder.write("a.obj", corners + "f 1 2 3 4 1 5 6 7 8 5\n"));
    EXPECT_TRUE(scene.warnings.empty());
    const Cage& cage = test::only_cage(scene);
    double area = 0;
    for (std::size_t i = 0; i + 2 < cage.face_vertices.size(); i += 3) {
        const auto corner = [&](std::size_t k) { return Vec3d(cage.positions[cage.face_vertices[i + k]]); };
        area += glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0))) / 2;
    }
    EXPECT_NEAR(area, 12, 1e-6);
}

TEST(PolygonCut, AFaceThatCrossesItselfIsAWarning)
{
    const test::TempFolder folder;
    const std::string file = "v 0 0 0\nv 3 3 0\nv 3 0 0\nv 0 1 0\nf 1 2 3 4\n";
    const Scene scene = load(folder.write("a.obj", file));
    EXPECT_TRUE(test::warns(scene, "a face crosses itself or is far from flat: its triangles may leave it (face 0)"));
}

// Few bytes of a file may be very many polygons of which each takes long.
TEST(PolygonCut, EarsAreNotSoughtWithoutEnd)
{
    const std::vector<Vec3f> arrow = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}};
    const std::vector<Vec3f> square = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    std::vector<std::uint32_t> cut;
    EarBudget budget(1);
    EXPECT_EQ(cut_polygon(arrow, budget, cut), CutPolygon::Whole);
    EXPECT_TRUE(budget.is_used_up());
    EXPECT_EQ(cut_polygon(arrow, budget, cut), CutPolygon::WithoutEars);
    EXPECT_EQ(cut_polygon(square, budget, cut), CutPolygon::Whole) << "a convex polygon takes nothing";
    EXPECT_EQ(cut.size(), 18u);
}

TEST(PolygonCut, EarsAreSoughtLongerInALargeFile)
{
    const std::vector<Vec3f> arrow = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}};
    const auto leaves = [&](std::size_t corners, std::uint64_t looks) {
        EarBudget budget = EarBudget::of_file(corners);
        budget.take(looks);
        std::vector<std::uint32_t> cut;
        return cut_polygon(arrow, budget, cut) != CutPolygon::WithoutEars;
    };
    constexpr std::uint64_t kMega = 1'000'000;
    EXPECT_TRUE(leaves(kMega, 2000 * kMega));
    EXPECT_FALSE(leaves(kMega, 3000 * kMega));
    EXPECT_TRUE(leaves(100 * kMega, 25'000 * kMega));
    EXPECT_FALSE(leaves(100 * kMega, 26'000 * kMega));
}

}  // namespace
}  // namespace occam::import
