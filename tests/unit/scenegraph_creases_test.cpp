// Tests of creases that OpenSubdiv cannot handle: they are dropped or taken around it, and no memory is overwritten.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/hash.h"
#include "scenegraph/cage.h"
#include "tests/support/campaign.h"
#include "tests/support/diced_mesh.h"
#include "tests/support/shape_builders.h"

namespace occam::test {
namespace {

/// Returns two quads over the same four vertices, back to back: each vertex has two faces and two edges.
Cage back_to_back()
{
    Cage cage;
    cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.2f}, {0, 1, 0}};
    cage.face_sizes = {4, 4};
    cage.face_vertices = {0, 1, 2, 3, 3, 2, 1, 0};
    return cage;
}

TEST(CreasesOfTwoFaces, StayOnlyIfBothAreInfinitelySharp)
{
    struct Case {
        std::vector<Crease> creases;
        std::size_t kept;
    };
    const Case cases[] = {
        {{{0, 1, 10}}, 0},
        {{{0, 1, 10}, {1, 2, 10}}, 0},  // vertices 0 and 2 have one crease each, and so has 1 without these
        {{{0, 1, 10}, {1, 2, 10}, {2, 3, 10}, {3, 0, 10}}, 4},
        {{{0, 1, 10}, {1, 2, 10}, {2, 3, 10}, {3, 0, 9.5f}}, 0},
        {{{0, 1, 3}, {1, 2, 3}, {2, 3, 3}, {3, 0, 3}}, 0},
    };
    for (const Case& c : cases) {
        Cage cage = back_to_back();
        cage.creases = c.creases;
        const std::vector<std::string> lines = sanitize(cage);
        EXPECT_EQ(cage.creases.size(), c.kept);
        EXPECT_EQ(lines.size(), c.kept == c.creases.size() ? 0u : 1u);
        EXPECT_TRUE(has_finite_surface(DicedCage(cage, 0)));
    }
}

/// Returns a cube whose edge from 0 to 1 has a vertex of two faces in its middle, the last one.
Cage cube_with_split_edge()
{
    const Cage cage = prism(4);
    const auto middle = static_cast<std::uint32_t>(cage.positions.size());
    Cage split = cage;
    split.positions.push_back((cage.positions[0] + cage.positions[1]) * 0.5f);
    split.face_sizes.clear(), split.face_vertices.clear(), split.creases.clear();
    std::size_t at = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        std::uint32_t added = 0;
        for (std::size_t c = 0; c < size; ++c) {
            const std::uint32_t v = cage.face_vertices[at + c], w = cage.face_vertices[at + (c + 1) % size];
            split.face_vertices.push_back(v);
            if (std::min(v, w) == 0 && std::max(v, w) == 1) split.face_vertices.push_back(middle), ++added;
        }
        split.face_sizes.push_back(size + added);
        at += size;
    }
    return split;
}

/// Makes a crease of each edge.
void crease_all(Cage& cage, float sharpness)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::size_t at = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::size_t c = 0; c < size; ++c)
            edges.insert(std::minmax(cage.face_vertices[at + c], cage.face_vertices[at + (c + 1) % size]));
        at += size;
    }
    for (const auto& [v, w] : edges) cage.creases.push_back({v, w, sharpness});
}

TEST(CreasesOfTwoFaces, LeaveThoseOfOtherVertices)
{
    Cage split = cube_with_split_edge();
    const auto middle = static_cast<std::uint32_t>(split.positions.size() - 1);
    split.creases = {{0, middle, 10}, {middle, 1, 2}, {2, 3, 5}};
    sanitize(split);
    ASSERT_EQ(split.creases.size(), 1u);
    EXPECT_EQ(split.creases[0].v0, 2u);
    EXPECT_TRUE(has_finite_surface(DicedCage(split, 0)));
}

TEST(CreasesOfTwoFaces, IncludeThoseAtAVertexOfFurtherFaces)
{
    // Four faces meet at vertex 0, but around it two and two of them close.
    Cage cage = back_to_back();
    for (const Vec3f p : {Vec3f(-1, 0, 0), Vec3f(-1, -1, 0.2f), Vec3f(0, -1, 0)}) cage.positions.push_back(p);
    cage.face_sizes.insert(cage.face_sizes.end(), {4, 4});
    cage.face_vertices.insert(cage.face_vertices.end(), {0, 4, 5, 6, 6, 5, 4, 0});
    cage.creases = {{0, 1, 10}, {1, 2, 10}, {2, 3, 10}, {3, 0, 10}, {0, 4, 3}, {6, 0, 10}};
    sanitize(cage);
    // Those of vertex 0 go, and then those of its neighbours.
    EXPECT_TRUE(cage.creases.empty());
    EXPECT_TRUE(has_finite_surface(DicedCage(cage, 0)));
}

/// A face that is turned over has borders all around, though each of its edges has two faces. OpenSubdiv cannot make the
/// surface of a pentagon that touches these (lod/unsafe_faces.h).
TEST(CreasesBesideAPair, StayAtABorder)
{
    const Cage whole = cube_with_split_edge();
    const auto middle = static_cast<std::uint32_t>(whole.positions.size() - 1);
    std::size_t at = 0;
    int turned = 0;
    for (const std::uint32_t size : whole.face_sizes) {
        if (size == 4) {
            Cage cage = whole;
            const auto first = cage.face_vertices.begin() + static_cast<std::ptrdiff_t>(at);
            std::reverse(first, first + size);
            crease_all(cage, 3);
            ASSERT_EQ(cage.creases.size(), 13u);
            sanitize(cage);
            EXPECT_EQ(cage.creases.size(), 11u);
            for (const Crease& c : cage.creases) EXPECT_TRUE(c.v0 != middle && c.v1 != middle);
            EXPECT_TRUE(has_finite_surface(DicedCage(cage, 0)));
            ++turned;
        }
        at += size;
    }
    EXPECT_EQ(turned, 4);
}

TEST(Creases, ThatAreNoEdgesAreDropped)
{
    Cage cage = prism(4);
    const std::uint32_t v = cage.face_vertices[0], across = cage.face_vertices[2];
    ASSERT_EQ(cage.face_sizes[0], 4u);
    cage.creases = {{v, across, 3}, {v, cage.face_vertices[1], 3}};
    const std::vector<std::string> lines = sanitize(cage);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0], "1 creases dropped: no such edge, or no sharpness");
    ASSERT_EQ(cage.creases.size(), 1u);
    EXPECT_EQ(cage.creases[0].v1, cage.face_vertices[1]);
}

/// Where nearly all edges among triangles are creases there are more of them around a face than OpenSubdiv has room for.
TEST(ManyCreases, AmongTrianglesDoNotOverflow)
{
    for (const std::uint32_t valence : {9u, 20u, 31u, 40u, 57u, 60u, 64u, 80u}) {
        if (!is_long() && valence != 9 && valence != 31 && valence != 64) continue;
        Cage cage = spindle(valence);
        std::size_t at = 0;
        for (const std::uint32_t size : cage.face_sizes) {
            for (std::size_t c = 0; c < size; ++c) {
                const std::uint32_t v = cage.face_vertices[at + c], w = cage.face_vertices[at + (c + 1) % size];
                if (v < w) cage.creases.push_back({v, w, 0.25f * static_cast<float>(1 + mix_bits(v * 64 + w) % 40)});
            }
            at += size;
        }
        EXPECT_TRUE(has_finite_surface(DicedCage(cage, 0)));
    }
}

}  // namespace
}  // namespace occam::test
