#include <gtest/gtest.h>

#include "base/error.h"
#include "scenegraph/cage.h"

namespace occam {
namespace {

// Returns three quads in a row, the second of which is a hole.
Cage strip()
{
    Cage cage;
    for (int i = 0; i < 4; ++i) cage.positions.emplace_back(i, 0, 0), cage.positions.emplace_back(i, 1, 0);
    for (std::uint32_t i = 0; i < 3; ++i)
        cage.face_sizes.push_back(4),
            cage.face_vertices.insert(cage.face_vertices.end(), {2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
    cage.holes = {1};
    return cage;
}

TEST(Sanitize, LeavesAGoodCageAlone)
{
    Cage cage = strip();
    cage.creases = {{0, 1, 2.5f}};
    const Cage before = cage;
    EXPECT_TRUE(sanitize(cage).empty());
    EXPECT_EQ(cage.face_vertices, before.face_vertices);
    EXPECT_EQ(cage.holes, before.holes);
    EXPECT_EQ(cage.creases.size(), 1u);
}

TEST(Sanitize, DropsTheFacesAroundAVertexThatTooManyShare)
{
    for (const std::uint32_t valence : {4096u, 4097u}) {
        Cage cage = strip();
        cage.positions.resize(8 + valence + 1, Vec3f(0.5f));
        for (std::uint32_t i = 0; i < valence; ++i) {
            cage.face_sizes.push_back(3);
            cage.face_vertices.insert(cage.face_vertices.end(), {8, 9 + i, 9 + (i + 1) % valence});
        }
        const auto lines = sanitize(cage);
        if (valence == 4096) {
            EXPECT_TRUE(lines.empty());
            continue;
        }
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_NE(lines[0].find("4097 faces dropped: more than 4096 of them meet"), std::string::npos) << lines[0];
        EXPECT_EQ(cage.face_count(), 3u);
    }
}

TEST(Sanitize, ADroppedFaceMovesTheHolesBehindIt)
{
    Cage cage = strip();
    cage.face_vertices[0] = 99;
    cage.face_slots = {3, 4, 5};
    cage.materials.resize(6);
    const auto lines = sanitize(cage);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NE(lines[0].find("1 faces dropped"), std::string::npos) << lines[0];
    EXPECT_EQ(cage.face_sizes.size(), 2u);
    EXPECT_EQ(cage.holes, std::vector<std::uint32_t>{0});
    EXPECT_EQ(cage.face_slots, (std::vector<std::uint16_t>{4, 5}));
    EXPECT_EQ(cage.face_vertices[0], 2u);
}

TEST(Sanitize, ADroppedFaceTakesItsHoleWithIt)
{
    Cage cage = strip();
    cage.face_vertices[4] = 99;
    sanitize(cage);
    EXPECT_TRUE(cage.holes.empty());
}

TEST(Sanitize, FacesOfVerticesThatAreNotFiniteAreDroppedAndBoundsStayTrue)
{
    Cage cage = strip();
    cage.positions[7] = {NAN, 1e30f, 0};
    EXPECT_EQ(sanitize(cage).size(), 2u);
    EXPECT_EQ(cage.face_sizes.size(), 2u);
    EXPECT_EQ(cage.bounds().hi.x, 3);
    EXPECT_EQ(cage.bounds().hi.y, 1);
}

TEST(Sanitize, RepeatedCornersAreTakenOutAndCrossedFacesDropped)
{
    Cage cage;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    cage.face_sizes = {4, 5, 4, 3, 2, 4};
    cage.face_vertices = {0, 1, 2, 3, /**/ 0, 0, 1, 2, 0, /**/ 0, 1, 0, 2, /**/ 1, 1, 2, /**/ 0, 1, /**/ 3, 3, 3, 3};
    cage.uv_sets = {
        {{{0, 0}, {1, 0}, {2, 0}}, {0, 0, 0, 0, /**/ 0, 1, 2, 0, 1, /**/ 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}};
    sanitize(cage);
    EXPECT_EQ(cage.face_sizes, (std::vector<std::uint32_t>{4, 3}));
    EXPECT_EQ(cage.face_vertices.size(), 7u);
    EXPECT_EQ(cage.uv_sets[0].indices.size(), 7u);
    const std::vector<std::uint32_t> triangle(cage.face_vertices.begin() + 4, cage.face_vertices.end());
    EXPECT_EQ(triangle, (std::vector<std::uint32_t>{1, 2, 0}));
}

TEST(Sanitize, TagsThatNameNothingAreDropped)
{
    Cage cage = strip();
    cage.creases = {{0, 1, 2}, {0, 99, 2}, {1, 1, 2}, {0, 2, NAN}, {0, 2, -1}, {0, 2, INFINITY}};
    cage.corners = {{0, 3}, {99, 3}};
    cage.holes = {1, 1, 77};
    EXPECT_EQ(sanitize(cage).size(), 3u);
    ASSERT_EQ(cage.creases.size(), 2u);
    EXPECT_EQ(cage.creases[1].sharpness, kInfiniteSharpness);
    EXPECT_EQ(cage.corners.size(), 1u);
    EXPECT_EQ(cage.holes, std::vector<std::uint32_t>{1});
}

TEST(Sanitize, PolygonsBeyondTheLimitAreDropped)
{
    Cage cage;
    for (std::uint32_t i = 0; i <= kMaxFaceCorners; ++i)
        cage.positions.emplace_back(i, i * i, 0), cage.face_vertices.push_back(i);
    cage.face_sizes = {kMaxFaceCorners + 1};
    EXPECT_EQ(sanitize(cage).size(), 1u);
    EXPECT_TRUE(cage.face_sizes.empty());
}

TEST(Sanitize, NormalsWithoutADirectionComeFromTheTriangles)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    cage.face_vertices = {0, 1, 2};
    cage.normals = {{0, 0, 0}, {0, 0, 7}, {NAN, 0, 0}};
    EXPECT_EQ(sanitize(cage).size(), 1u);
    for (Vec3f n : cage.normals) EXPECT_EQ(n, Vec3f(0, 0, 1));
}

TEST(Sanitize, SkinWeightsSumToOne)
{
    Cage cage;
    cage.scheme = Scheme::Triangles;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    cage.face_vertices = {0, 1, 2};
    cage.skin.sets = 1;
    cage.skin.joints.resize(3);
    cage.skin.weights = {{1, 1, 1, 1}, {0, 0, 0, 0}, {-1, NAN, 0.5f, 0.5f}};
    sanitize(cage);
    EXPECT_EQ(cage.skin.weights[0], Vec4f(0.25f));
    EXPECT_EQ(cage.skin.weights[1], Vec4f(1, 0, 0, 0));
    EXPECT_EQ(cage.skin.weights[2], Vec4f(0, 0, 0.5f, 0.5f));
}

TEST(Sanitize, RefusesArraysThatDoNotFitTogether)
{
    Cage cage = strip();
    cage.face_sizes.push_back(4);
    EXPECT_THROW(sanitize(cage), Error);
    cage = strip();
    cage.colors.resize(3);
    EXPECT_THROW(sanitize(cage), Error);
    cage = strip();
    cage.uv_sets = {{{{0, 0}}, {0, 0}}};
    EXPECT_THROW(sanitize(cage), Error);
    cage = strip();
    cage.scheme = Scheme::Triangles;
    EXPECT_THROW(sanitize(cage), Error);
}

// Two hexagons share three edges, as in OpenSubdiv's own shape catmark_val2_interior. Creases at the two vertices where
// these close are dropped. One beside them, at the border, stays (lod/unsafe_faces.h).
TEST(Sanitize, CreasesWhereTwoFacesCloseAtABorderAreDropped)
{
    Cage cage;
    for (int i = 0; i < 8; ++i) cage.positions.emplace_back(i % 4, 0, i / 4);
    cage.face_sizes = {6, 6};
    cage.face_vertices = {0, 1, 2, 6, 5, 4, 7, 5, 6, 2, 1, 3};
    cage.creases = {{1, 2, 5}, {2, 6, 5}, {0, 1, 5}};
    const auto lines = sanitize(cage);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0], "2 creases dropped: at a vertex of two faces");
    ASSERT_EQ(cage.creases.size(), 1u);
    EXPECT_EQ(cage.creases[0].v0, 0u);
}

}  // namespace
}  // namespace occam
